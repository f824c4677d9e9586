//! A serial port: opened for one process alone, raw, and never waited for.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Write};
use std::os::unix::fs::OpenOptionsExt;

use rustix::fs::OFlags;
use rustix::termios::{OptionalActions, QueueSelector, tcflush, tcgetattr, tcsetattr};
use tokio::io::unix::AsyncFd;

/// Why a port does not open.
#[derive(Debug, thiserror::Error)]
pub enum PortError {
    /// It is not there, or not for this user.
    #[error("`{path}` cannot be opened: {source}")]
    Open {
        /// Path of the device.
        path: String,
        /// Why not.
        source: io::Error,
    },
    /// Another process has it.
    #[error("`{path}` is in use by another process")]
    InUse {
        /// Path of the device.
        path: String,
    },
    /// It is no terminal, or has no such speed.
    #[error("`{path}` cannot be set to {baud} baud: {source}")]
    Setting {
        /// Path of the device.
        path: String,
        /// The speed asked for.
        baud: u32,
        /// Why not.
        source: io::Error,
    },
}

/// An open serial port.
#[derive(Debug)]
pub struct Port(AsyncFd<File>);

impl Port {
    /// Opens a port: 8 data bits, no parity, 1 stop bit, no flow control; what was left in its
    /// queues is thrown away.
    #[expect(unsafe_code, reason = "`AsyncFd::register` is unsafe for a file")]
    pub fn open(path: &str, baud: u32) -> Result<Self, PortError> {
        let flags = OFlags::NONBLOCK | OFlags::NOCTTY;
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .custom_flags(flags.bits().cast_signed())
            .open(path)
            .map_err(|source| PortError::Open { path: path.to_owned(), source })?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(PortError::InUse { path: path.to_owned() });
            }
            Err(TryLockError::Error(source)) => {
                return Err(PortError::Open { path: path.to_owned(), source });
            }
        }
        let setting = |source| PortError::Setting { path: path.to_owned(), baud, source };
        set_up(&file, baud).map_err(setting)?;
        // SAFETY: a file owns its descriptor, keeps it open and is not exchanged while it is here.
        let registered = unsafe { AsyncFd::register(file) };
        registered.map(Self).map_err(|error| setting(error.into()))
    }

    /// Waits for bytes. None are lost when this is dropped while it waits.
    pub async fn read(&self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            let mut ready = self.0.readable().await?;
            match ready.try_io(|file| file.get_ref().read(buffer)) {
                Ok(Ok(0)) => return Err(io::ErrorKind::UnexpectedEof.into()),
                Ok(read) => return read,
                Err(_would_block) => {}
            }
        }
    }

    /// Sends a line, or nothing or a part of it if the other end does not take it at once: a
    /// command that waits is a command that comes too late.
    pub fn send(&self, line: &str) -> io::Result<()> {
        match self.0.get_ref().write(line.as_bytes()) {
            Ok(_) => Ok(()),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(()),
            Err(error) => Err(error),
        }
    }
}

impl Drop for Port {
    fn drop(&mut self) {
        // Closing a port waits for what it could not send, up to half a minute; an unplugged one
        // has nothing to throw away.
        tcflush(self.0.get_ref(), QueueSelector::IOFlush).ok();
    }
}

fn set_up(file: &File, baud: u32) -> io::Result<()> {
    let mut settings = tcgetattr(file)?;
    settings.make_raw();
    settings.set_speed(baud)?;
    tcsetattr(file, OptionalActions::Now, &settings)?;
    tcflush(file, QueueSelector::IOFlush)?;
    Ok(())
}
