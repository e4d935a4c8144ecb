//! Words of a file in a message.

/// A text as a part of a message of one line: line ends and other control characters are blanks.
pub fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::one_line;

    #[test]
    fn line_ends_are_blanks() {
        assert_eq!(one_line("a\nb\r\nc\td\u{1b}[2J é"), "a b  c d [2J é");
    }
}
