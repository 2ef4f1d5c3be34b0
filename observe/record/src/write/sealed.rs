//! A file that is a whole MCAP file at every moment, whatever becomes of the process that writes it.
//!
//! What the MCAP writer makes is gathered in memory. To commit it, one write puts it where the data ends, followed by a
//! tail: an end of data, a footer without a summary, and the magic bytes. A reader finds a complete file without an
//! index and goes through it from the start (MCAP specification, "Footer": `summary_start` 0). The next commit begins
//! where the tail did.

use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::os::unix::fs::FileExt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// `DataEnd` without a checksum, `Footer` without a summary, magic (MCAP specification, "Records").
const TAIL: [u8; 50] = {
    let mut tail = [0; 50];
    tail[0] = 0x0F;
    tail[1] = 4;
    tail[13] = 0x02;
    tail[14] = 20;
    let magic = [0x89, b'M', b'C', b'A', b'P', 0x30, b'\r', b'\n'];
    let mut at = 0;
    while at < magic.len() {
        tail[42 + at] = magic[at];
        at += 1;
    }
    tail
};

/// Where bytes are put for good.
pub(super) trait Store: Send {
    /// Write all of `bytes` at `offset`.
    fn write_all_at(&self, bytes: &[u8], offset: u64) -> io::Result<()>;
    /// Nothing lies beyond `len`.
    fn set_len(&self, len: u64) -> io::Result<()>;
}

impl Store for File {
    fn write_all_at(&self, bytes: &[u8], offset: u64) -> io::Result<()> {
        FileExt::write_all_at(self, bytes, offset)
    }

    fn set_len(&self, len: u64) -> io::Result<()> {
        self.set_len(len)
    }
}

/// What the MCAP writer writes to. Clones are the same one.
#[derive(Clone, Default)]
pub(super) struct Gathered(Arc<Mutex<Bytes>>);

#[derive(Default)]
struct Bytes {
    fresh: Vec<u8>,
    /// Bytes taken before.
    taken: u64,
}

impl Gathered {
    fn lock(&self) -> MutexGuard<'_, Bytes> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn take(&self) -> Vec<u8> {
        let mut bytes = self.lock();
        bytes.taken += bytes.fresh.len() as u64;
        std::mem::take(&mut bytes.fresh)
    }
}

impl Write for Gathered {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.lock().fresh.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Gathered {
    /// Tells where it is; it never goes back.
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let bytes = self.lock();
        let here = bytes.taken + bytes.fresh.len() as u64;
        match to {
            SeekFrom::Current(0) => Ok(here),
            SeekFrom::Start(at) if at == here => Ok(here),
            SeekFrom::Start(_) | SeekFrom::End(_) | SeekFrom::Current(_) => {
                Err(io::Error::new(io::ErrorKind::Unsupported, "a recording is written from start to end"))
            }
        }
    }
}

/// The file.
pub(super) struct Sealed {
    store: Box<dyn Store>,
    gathered: Gathered,
    /// Where the data ends, and the tail begins.
    end: u64,
}

impl Sealed {
    pub(super) fn new(store: Box<dyn Store>, gathered: Gathered) -> Self {
        Self { store, gathered, end: 0 }
    }

    /// Bytes of data so far.
    pub(super) const fn len(&self) -> u64 {
        self.end
    }

    /// Put down what was gathered, with a tail. After an error the file is what it was before.
    pub(super) fn commit(&mut self) -> io::Result<()> {
        let mut bytes = self.gathered.take();
        if bytes.is_empty() {
            return Ok(());
        }
        let fresh = bytes.len() as u64;
        bytes.extend_from_slice(&TAIL);
        self.put(&bytes)?;
        self.end += fresh;
        Ok(())
    }

    /// Put down the last of it, which brings a summary and an end of its own.
    pub(super) fn finish(&mut self) -> io::Result<()> {
        let bytes = self.gathered.take();
        self.put(&bytes)?;
        self.end += bytes.len() as u64;
        self.store.set_len(self.end)
    }

    fn put(&self, bytes: &[u8]) -> io::Result<()> {
        self.store.write_all_at(bytes, self.end).inspect_err(|_| {
            // There was room for the tail where it was. If even this fails there is nothing left to do.
            let _ = self.store.set_len(self.end).and_then(|()| self.store.write_all_at(&TAIL, self.end));
        })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A disk with so much room and no more.
    #[derive(Clone, Default)]
    pub(in crate::write) struct SmallDisk(pub(in crate::write) Arc<Mutex<(Vec<u8>, usize)>>);

    impl Store for SmallDisk {
        fn write_all_at(&self, bytes: &[u8], offset: u64) -> io::Result<()> {
            let mut disk = self.0.lock().unwrap();
            let (held, room) = &mut *disk;
            let from = usize::try_from(offset).unwrap();
            let fits = (*room).saturating_sub(from).min(bytes.len());
            held.resize(held.len().max(from + fits), 0);
            held[from..from + fits].copy_from_slice(&bytes[..fits]);
            if fits < bytes.len() { Err(io::Error::from_raw_os_error(28)) } else { Ok(()) }
        }

        fn set_len(&self, len: u64) -> io::Result<()> {
            self.0.lock().unwrap().0.truncate(usize::try_from(len).unwrap());
            Ok(())
        }
    }

    #[test]
    fn after_each_commit_and_after_a_full_disk_the_file_ends_with_the_tail() {
        let disk = SmallDisk::default();
        disk.0.lock().unwrap().1 = 200;
        let mut gathered = Gathered::default();
        let mut sealed = Sealed::new(Box::new(disk.clone()), gathered.clone());
        for data in [[1_u8; 60], [2; 60]] {
            gathered.write_all(&data).unwrap();
            sealed.commit().unwrap();
            assert!(disk.0.lock().unwrap().0.ends_with(&TAIL));
        }
        let before = disk.0.lock().unwrap().0.clone();
        assert_eq!(before.len(), 170);
        gathered.write_all(&[3; 60]).unwrap();
        assert_eq!(sealed.commit().unwrap_err().kind(), io::ErrorKind::StorageFull);
        assert_eq!(disk.0.lock().unwrap().0, before);
    }
}
