//! Messages of our own, with the schema that lets any reader decode them.
//!
//! A message is written down once, field by field with its number: `prost` encodes and decodes the structure, and its
//! descriptor is made from the same lines. Numbers are for ever: a field may be added, none may be changed or used
//! anew, or old recordings are misread.

use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{
    DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet, OneofDescriptorProto,
};

/// The package of all messages.
const PACKAGE: &str = "drover";

/// A message of our own.
pub(super) trait Own {
    /// Its name, without the package.
    const NAME: &'static str;

    /// Its fields.
    fn fields() -> Vec<Field>;

    /// The files that describe it, those it needs first.
    fn files() -> Vec<FileDescriptorProto> {
        let mut needs: Vec<FileDescriptorProto> = Vec::new();
        for file in Self::fields().into_iter().flat_map(|field| field.shape.files) {
            if needs.iter().all(|known| known.name != file.name) {
                needs.push(file);
            }
        }
        let file = FileDescriptorProto {
            name: Some(format!("{PACKAGE}/{}.proto", Self::NAME)),
            package: Some(PACKAGE.into()),
            dependency: needs.iter().map(|file| file.name().into()).collect(),
            message_type: vec![described::<Self>()],
            syntax: Some("proto3".into()),
            ..FileDescriptorProto::default()
        };
        needs.push(file);
        needs
    }
}

/// The schema of `M`: a set of files that needs nothing else.
pub(super) fn schema<M: Own>() -> foxglove::Schema {
    let set = FileDescriptorSet { file: M::files() };
    foxglove::Schema::new(format!("{PACKAGE}.{}", M::NAME), "protobuf", prost::Message::encode_to_vec(&set))
}

/// A field of a message.
pub(super) struct Field {
    pub(super) name: &'static str,
    pub(super) number: i32,
    pub(super) shape: Shape,
}

/// What a field holds.
pub(super) struct Shape {
    kind: Type,
    repeated: bool,
    /// It can be absent, which is not the same as 0.
    optional: bool,
    /// Full name of the message that it holds.
    message: Option<String>,
    /// The files that describe that message.
    files: Vec<FileDescriptorProto>,
}

/// A Rust type that can be a field.
pub(super) trait Shaped {
    fn shape() -> Shape;
}

fn plain(kind: Type) -> Shape {
    Shape { kind, repeated: false, optional: false, message: None, files: Vec::new() }
}

/// What a message is as a field of another.
pub(super) fn nested<M: Own>() -> Shape {
    Shape { message: Some(format!(".{PACKAGE}.{}", M::NAME)), files: M::files(), ..plain(Type::Message) }
}

macro_rules! plain_shapes {
    ($($type:ty => $kind:ident,)*) => {
        $(impl Shaped for $type {
            fn shape() -> Shape {
                plain(Type::$kind)
            }
        })*
    };
}

plain_shapes! {
    bool => Bool,
    u32 => Uint32,
    u64 => Uint64,
    f64 => Double,
    String => String,
    Vec<u8> => Bytes,
}

impl<T: Shaped> Shaped for Option<T> {
    fn shape() -> Shape {
        Shape { optional: true, ..T::shape() }
    }
}

impl<M: Own + Shaped> Shaped for Vec<M> {
    fn shape() -> Shape {
        Shape { repeated: true, ..M::shape() }
    }
}

fn described<M: Own + ?Sized>() -> DescriptorProto {
    let mut message = DescriptorProto { name: Some(M::NAME.into()), ..DescriptorProto::default() };
    for Field { name, number, shape } in M::fields() {
        // A message can be absent anyway; anything else needs an alternative of its own, as `protoc` writes it.
        let explicit = shape.optional && shape.kind != Type::Message;
        let oneof_index = explicit.then_some(message.oneof_decl.len() as i32);
        if explicit {
            let oneof = OneofDescriptorProto { name: Some(format!("_{name}")), ..OneofDescriptorProto::default() };
            message.oneof_decl.push(oneof);
        }
        message.field.push(FieldDescriptorProto {
            name: Some(name.into()),
            number: Some(number),
            label: Some(if shape.repeated { Label::Repeated } else { Label::Optional } as i32),
            r#type: Some(shape.kind as i32),
            type_name: shape.message,
            oneof_index,
            proto3_optional: explicit.then_some(true),
            ..FieldDescriptorProto::default()
        });
    }
    message
}

/// Makes a message: `[what prost calls it] name: Rust type = number`.
macro_rules! message {
    (
        $(#[$about:meta])*
        $message:ident {
            $(
                $(#[$what:meta])*
                [$kind:ident $($label:ident)?] $field:ident: $type:ty = $number:tt,
            )*
        }
    ) => {
        $(#[$about])*
        #[derive(Clone, PartialEq, ::prost::Message)]
        pub struct $message {
            $(
                $(#[$what])*
                #[prost($kind $(, $label)?, tag = $number)]
                pub $field: $type,
            )*
        }

        impl $message {
            /// Its fields by name, in words in which no two values are alike: to say where two messages differ.
            #[must_use]
            pub fn in_words(&self) -> Vec<(&'static str, String)> {
                vec![$((stringify!($field), format!("{:?}", self.$field)),)*]
            }
        }

        impl $crate::foxglove::message::Own for $message {
            const NAME: &'static str = stringify!($message);

            fn fields() -> Vec<$crate::foxglove::message::Field> {
                use $crate::foxglove::message::{Field, Shaped};
                vec![$(Field { name: stringify!($field), number: $number, shape: <$type as Shaped>::shape() },)*]
            }
        }

        impl $crate::foxglove::message::Shaped for $message {
            fn shape() -> $crate::foxglove::message::Shape {
                $crate::foxglove::message::nested::<Self>()
            }
        }

        impl ::foxglove::Encode for $message {
            type Error = ::prost::EncodeError;

            fn get_schema() -> Option<::foxglove::Schema> {
                Some($crate::foxglove::message::schema::<Self>())
            }

            fn get_message_encoding() -> String {
                "protobuf".into()
            }

            fn encode(&self, buffer: &mut impl ::prost::bytes::BufMut) -> Result<(), Self::Error> {
                ::prost::Message::encode(self, buffer)
            }

            fn encoded_len(&self) -> Option<usize> {
                Some(::prost::Message::encoded_len(self))
            }
        }
    };
}

pub(super) use message;
