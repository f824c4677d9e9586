//! A terminal, at whose other end a test types and looks.

use std::fs::File;
use std::io::{Read, Write};
use std::num::NonZero;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{LocalModes, Winsize, tcgetattr, tcsetwinsize};

use rsrs_testing::network::TIMEOUT;

use crate::processes::Process;

const POLL_PERIOD: Duration = Duration::from_millis(20);

/// A terminal for the standard input of a program, or for all of it.
pub struct Terminal {
    keyboard: File,
    screen: String,
}

impl Terminal {
    /// A terminal of its own, which controls no process.
    pub fn open() -> Self {
        let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY;
        let keyboard = openpt(flags).expect("there are terminals to be had");
        grantpt(&keyboard).expect("it is ours");
        unlockpt(&keyboard).expect("it is ours");
        let screen = ptsname(&keyboard, Vec::new()).expect("it has a name");
        let screen = screen.into_string().expect("its name is text");
        Self { keyboard: File::from(keyboard), screen }
    }

    /// The end that the program reads from.
    pub fn input(&self) -> Stdio {
        self.file().into()
    }

    /// Types a line.
    pub fn type_line(&mut self, line: &str) {
        writeln!(self.keyboard, "{line}").expect("somebody reads it");
    }

    fn file(&self) -> File {
        let mut options = File::options();
        options.read(true).write(true);
        options.open(&self.screen).expect("the terminal is there")
    }
}

impl Terminal {
    /// Everything that programs have printed on it, once all of them have ended.
    pub fn printed(mut self) -> String {
        let mut printed = Vec::new();
        let mut part = [0; 4096];
        // Linux ends it by an error, once nobody holds the other end.
        while let Ok(n @ 1..) = self.keyboard.read(&mut part) {
            printed.extend_from_slice(&part[..n]);
        }
        String::from_utf8(printed).expect("words are UTF-8")
    }
}

/// A program that has a terminal to itself, as in a window of so many columns and rows.
pub struct Window {
    terminal: Terminal,
    /// Kept open, so that what the program has written last can be read.
    file: File,
    process: Process,
    screen: Arc<Mutex<vt100::Parser>>,
}

impl Window {
    /// Starts a program in a new window of so many columns and rows.
    pub fn open(program: &Command, size: (u16, u16)) -> Self {
        let terminal = Terminal::open();
        let file = terminal.file();
        let screen = Arc::new(Mutex::new(parser(size)));
        // A terminal that controls its program reports other sizes to it.
        let mut command = Command::new("setsid");
        command.args(["--ctty", "--wait"]).arg(program.get_program()).args(program.get_args());
        for (name, value) in program.get_envs() {
            match value {
                Some(value) => command.env(name, value),
                None => command.env_remove(name),
            };
        }
        command.env("TERM", "xterm-256color").env("LC_ALL", "C.UTF-8").env_remove("NO_COLOR");
        command.stdin(terminal.input()).stdout(terminal.input()).stderr(terminal.input());
        if let Some(folder) = program.get_current_dir() {
            command.current_dir(folder);
        }
        set_size(&terminal.keyboard, size);
        let process = Process(command.spawn().expect("every Linux has `setsid`"));
        let window = Self { terminal, file, process, screen };
        window.look();
        window
    }

    /// Reads what the program writes, for as long as there is a window.
    fn look(&self) {
        let mut output = self.terminal.keyboard.try_clone().expect("it is a file");
        let screen = Arc::clone(&self.screen);
        std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            while let Ok(n @ 1..) = output.read(&mut bytes) {
                lock(&screen).process(&bytes[..n]);
            }
        });
    }

    /// Changes the size of the window.
    pub fn resize(&self, size: (u16, u16)) {
        lock(&self.screen).screen_mut().set_size(letters(size.1), letters(size.0));
        set_size(&self.terminal.keyboard, size);
    }

    /// Presses keys.
    pub fn press(&mut self, keys: &str) {
        self.terminal.keyboard.write_all(keys.as_bytes()).expect("somebody reads it");
    }

    /// What is on the screen.
    pub fn text(&self) -> String {
        lock(&self.screen).screen().contents()
    }

    /// Waits until something is on the screen.
    pub fn wait_for(&mut self, what: &str) {
        self.wait_until(what, |text| text.contains(what));
    }

    /// Waits until what is on the screen is as it should be.
    pub fn wait_until(&mut self, what: &str, is_so: impl Fn(&str) -> bool) {
        let start = Instant::now();
        while !is_so(&self.text()) {
            let ended = self.process.0.try_wait().expect("it is our child");
            let is_late = start.elapsed() > TIMEOUT;
            // What was written last is still being read when the program ends.
            assert!(!is_late, "{what} never shows ({ended:?}):\n{}", self.text());
            std::thread::sleep(POLL_PERIOD);
        }
    }

    /// Whether the window is as a shell wants it: its own screen, letters echoed, a cursor.
    pub fn is_as_before(&self) -> bool {
        let modes = tcgetattr(&self.file).expect("it is a terminal").local_modes;
        let screen = lock(&self.screen);
        let screen = screen.screen();
        modes.contains(LocalModes::ECHO | LocalModes::ICANON)
            && !screen.alternate_screen()
            && !screen.hide_cursor()
    }

    /// The process of the program.
    pub fn process(&self) -> &Process {
        &self.process
    }

    /// Waits for the end of the program, and until all that it wrote was read.
    pub fn ended(&mut self) -> ExitStatus {
        let (status, _) = self.process.wait();
        let start = Instant::now();
        while !self.is_as_before() && start.elapsed() < Duration::from_secs(5) {
            std::thread::sleep(POLL_PERIOD);
        }
        status
    }
}

fn parser((columns, rows): (u16, u16)) -> vt100::Parser {
    vt100::Parser::new(letters(rows), letters(columns), 0)
}

fn letters(n: u16) -> NonZero<u16> {
    NonZero::new(n).expect("a window has some letters")
}

fn set_size(terminal: &File, (columns, rows): (u16, u16)) {
    let size = Winsize { ws_row: rows, ws_col: columns, ws_xpixel: 0, ws_ypixel: 0 };
    tcsetwinsize(terminal, size).expect("it is a terminal");
}

fn lock(screen: &Mutex<vt100::Parser>) -> MutexGuard<'_, vt100::Parser> {
    screen.lock().unwrap_or_else(PoisonError::into_inner)
}
