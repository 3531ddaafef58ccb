//! Tokens of VRML text: words, numbers, strings and brackets.

use crate::io::error::Fault;

/// Characters of a token that an error message shows.
const MAX_SHOWN: usize = 30;

/// One token.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token {
    Number(f64),
    Word(String),
    Text(String),
    /// One of `{ } [ ] ( ) |`.
    Mark(char),
}

/// Splits text into tokens with their lines; commas are blanks, `#` begins a comment.
pub(super) struct Lexer<'a> {
    rest: &'a str,
    line: usize,
    peeked: Option<Option<(usize, Token)>>,
}

impl<'a> Lexer<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { rest: text, line: 1, peeked: None }
    }

    /// The line of the next token.
    pub(super) fn line(&self) -> usize {
        match &self.peeked {
            Some(Some((line, _))) => *line,
            _ => self.line,
        }
    }

    /// The next token, which is not consumed.
    pub(super) fn peek(&mut self) -> Result<Option<&Token>, Fault> {
        if self.peeked.is_none() {
            self.peeked = Some(self.read()?);
        }
        Ok(self.peeked.as_ref().and_then(|p| p.as_ref()).map(|(_, token)| token))
    }

    /// Consumes the next token.
    pub(super) fn next(&mut self) -> Result<Option<Token>, Fault> {
        let taken = match self.peeked.take() {
            Some(peeked) => peeked,
            None => self.read()?,
        };
        Ok(taken.map(|(_, token)| token))
    }

    /// Consumes the next token if it is this mark.
    pub(super) fn take(&mut self, mark: char) -> Result<bool, Fault> {
        let found = self.peek()? == Some(&Token::Mark(mark));
        if found {
            self.next()?;
        }
        Ok(found)
    }

    fn skip_blanks(&mut self) {
        loop {
            let trimmed = self.rest.trim_start_matches(|c: char| c.is_whitespace() || c == ',');
            let skipped = &self.rest[..self.rest.len() - trimmed.len()];
            self.line += skipped.bytes().filter(|&b| b == b'\n').count();
            self.rest = trimmed;
            if !self.rest.starts_with('#') {
                return;
            }
            let end = self.rest.find(['\n', '\r']).unwrap_or(self.rest.len());
            self.rest = &self.rest[end..];
        }
    }

    fn read(&mut self) -> Result<Option<(usize, Token)>, Fault> {
        self.skip_blanks();
        let line = self.line;
        let Some(first) = self.rest.chars().next() else { return Ok(None) };
        if first == '"' {
            return self.string().map(|text| Some((line, Token::Text(text))));
        }
        if "{}[]()|".contains(first) {
            self.rest = &self.rest[1..];
            return Ok(Some((line, Token::Mark(first))));
        }
        let ends = |c: char| c.is_whitespace() || ",{}[]()|\"#".contains(c);
        let end = self.rest.find(ends).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        Ok(Some((line, number_or_word(word, line)?)))
    }

    fn string(&mut self) -> Result<String, Fault> {
        let start = self.line;
        let mut out = String::new();
        let mut escaped = false;
        for (i, c) in self.rest.char_indices().skip(1) {
            if c == '\n' {
                self.line += 1;
            }
            match c {
                _ if escaped => {
                    out.push(c);
                    escaped = false;
                }
                '\\' => escaped = true,
                '"' => {
                    self.rest = &self.rest[i + 1..];
                    return Ok(out);
                }
                _ => out.push(c),
            }
        }
        Err(Fault::at(start, "a quoted string is never closed"))
    }
}

fn number_or_word(word: &str, line: usize) -> Result<Token, Fault> {
    let begins = word.trim_start_matches(['+', '-', '.']).starts_with(|c: char| c.is_ascii_digit());
    if !begins {
        return Ok(Token::Word(word.to_owned()));
    }
    if let Some(hex) = word.strip_prefix("0x").or(word.strip_prefix("0X"))
        && let Ok(value) = u32::from_str_radix(hex, 16)
    {
        return Ok(Token::Number(f64::from(value)));
    }
    match word.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(Token::Number(value)),
        _ => {
            let shown: String = word.chars().take(MAX_SHOWN).collect();
            Err(Fault::at(line, format!("{shown:?} is not a number")))
        }
    }
}
