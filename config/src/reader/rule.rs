//! What text may be.

/// Longest name.
pub(crate) const NAME_LEN_MAX: usize = 64;

/// A rule for text.
pub(crate) struct TextRule {
    pub(crate) allowed: &'static str,
    pub(crate) advice: &'static str,
    pub(crate) accepts: fn(&str) -> bool,
}

/// A name: of a swarm, a kind, a world.
pub(crate) const NAME: TextRule = TextRule {
    allowed: "1 to 64 letters, digits, '_' or '-'",
    advice: "choose a name that a file could have",
    accepts: |text| crate::path::is_bare_key(text) && text.len() <= NAME_LEN_MAX,
};

/// A folder.
pub(crate) const FOLDER: TextRule = TextRule {
    allowed: "the path of a folder",
    advice: "name a folder; it is made if need be",
    accepts: |text| !text.is_empty() && text.len() <= 4_096 && !text.contains('\0'),
};

/// A file.
pub(crate) const FILE: TextRule = TextRule {
    allowed: "the path of a file",
    advice: "name a file, relative to this one's folder",
    accepts: |text| !text.is_empty() && text.len() <= 4_096 && !text.contains('\0'),
};

/// An IPv4 address.
pub(crate) const IPV4: TextRule = TextRule {
    allowed: "an IPv4 address",
    advice: "write four numbers with dots, such as \"127.0.0.1\"",
    accepts: |text| text.parse::<core::net::Ipv4Addr>().is_ok(),
};

/// An IPv4 multicast group.
pub(crate) const IPV4_GROUP: TextRule = TextRule {
    allowed: "an IPv4 multicast group in 224.0.0.0/4",
    advice: "choose one of the administratively scoped groups, such as \"239.255.77.1\"",
    accepts: |text| text.parse::<core::net::Ipv4Addr>().is_ok_and(|group| group.is_multicast()),
};
