//! Scanner for HPGL plots, and the escape sequences for plotters and printers around the
//! instructions.

/// Default terminator of a label (ETX). The instruction DT changes it.
pub(in crate::formats) const END_OF_TEXT: u8 = 3;
/// Escape character, which starts a sequence for the device.
pub(in crate::formats) const ESCAPE: u8 = 27;

/// Skips the escape sequences before a plot.
pub(super) fn without_escapes(text: &str) -> &str {
    let mut scan = Scanner::new(text);
    scan.begin();
    text.get(scan.at..).unwrap_or_default()
}

/// Cursor over a plot. It skips escape sequences, which address the device and not the plot.
#[derive(Debug)]
pub(in crate::formats) struct Scanner<'t> {
    pub(in crate::formats) text: &'t str,
    pub(in crate::formats) at: usize,
    /// False once a search for a further plot found none, so that the search is not repeated for
    /// each sequence.
    more_plots: bool,
}

impl<'t> Scanner<'t> {
    pub(in crate::formats) fn new(text: &'t str) -> Self {
        Self {
            text,
            at: 0,
            more_plots: true,
        }
    }

    pub(in crate::formats) fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    pub(in crate::formats) fn skip(&mut self, passes: impl Fn(u8) -> bool) {
        while self.peek().is_some_and(&passes) {
            self.at += 1;
        }
    }

    fn take(&mut self) -> Option<u8> {
        let byte = self.peek()?;
        self.at += 1;
        Some(byte)
    }

    /// Moves to the next instruction and returns its first byte; `None` at the end.
    pub(in crate::formats) fn begin(&mut self) -> Option<u8> {
        loop {
            self.skip(is_separator);
            match self.peek()? {
                ESCAPE => self.escape(),
                // Printer job language (PJL) around the plot.
                b'@' => self.skip_printer_line(),
                byte => return Some(byte),
            }
        }
    }

    /// Skips a PJL line such as `@PJL ENTER LANGUAGE=HPGL2`. After a switch to PCL, skips to the
    /// next plot.
    fn skip_printer_line(&mut self) {
        let start = self.at;
        self.skip(|byte| byte != b'\n');
        let line = self.text.get(start..self.at).unwrap_or_default();
        if line.to_ascii_uppercase().contains("LANGUAGE")
            && line.to_ascii_uppercase().contains("PCL")
        {
            self.skip_to_plot();
        }
    }

    /// Skips printer data up to the next plot within it, which begins with `ESC % number B`.
    /// Returns false without one.
    fn skip_to_plot(&mut self) -> bool {
        if !self.more_plots {
            return false;
        }
        let rest = self.text.get(self.at..).unwrap_or_default();
        let begins = rest.match_indices("\u{1b}%").find(|(at, sign)| {
            let number = rest.get(at + sign.len()..).unwrap_or_default();
            let letter =
                number.trim_start_matches(|sign: char| sign.is_ascii_digit() || sign == '-');
            number.len() - letter.len() <= 2 && letter.starts_with('B')
        });
        if let Some((at, _)) = begins {
            self.at += at;
        }
        self.more_plots = begins.is_some();
        self.more_plots
    }

    /// Skips an escape sequence: `ESC . letter numbers :` of plotters, or `ESC % number letter` and
    /// similar ones of printers.
    ///
    /// `ESC % number A` ends a plot within printer data, and so does `ESC E` if another plot
    /// follows.
    fn escape(&mut self) {
        let start = self.at;
        self.at += 1;
        match self.take() {
            Some(b'E') => {
                self.skip_to_plot();
            }
            Some(b'.') => {
                self.at += usize::from(self.peek().is_some_and(|byte| byte.is_ascii()));
                self.skip(|byte| byte.is_ascii_digit() || byte == b';');
                self.skip_one(b':');
            }
            Some(b'%' | b'&' | b'*' | b'(' | b')') => {
                self.skip(|byte| !byte.is_ascii_uppercase() && byte.is_ascii_graphic());
                self.at += usize::from(self.peek().is_some_and(|byte| byte.is_ascii_uppercase()));
                let sequence = self.text.get(start..self.at).unwrap_or_default();
                if sequence.starts_with("\u{1b}%")
                    && sequence.ends_with('A')
                    && !self.skip_to_plot()
                {
                    self.at = self.text.len();
                }
            }
            _ => {}
        }
    }

    pub(in crate::formats) fn skip_one(&mut self, byte: u8) {
        self.at += usize::from(self.peek() == Some(byte));
    }
}

pub(in crate::formats) fn is_blank(byte: u8) -> bool {
    byte.is_ascii_whitespace() || byte == 0
}

fn is_separator(byte: u8) -> bool {
    is_blank(byte) || matches!(byte, b';' | b':' | b',' | END_OF_TEXT | b'\x1a')
}
