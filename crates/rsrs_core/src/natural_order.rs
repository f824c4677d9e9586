//! The order in which people count: `run_2` before `run_10`.

/// A key by which names and paths are sorted: their texts and the numbers within them.
///
/// # Example
///
/// ```
/// use rsrs_core::natural_order::natural_key;
///
/// let mut runs = ["run_10/bag", "run_2/bag", "run"];
/// runs.sort_by_key(|run| natural_key(run));
/// assert_eq!(runs, ["run", "run_2/bag", "run_10/bag"]);
/// ```
pub fn natural_key(name: &str) -> Vec<(String, Option<u64>)> {
    let mut key: Vec<(String, Option<u64>)> = Vec::new();
    let is_digit = |character: &char| character.is_ascii_digit();
    let mut rest = name;
    while !rest.is_empty() {
        let text = &rest[..rest.find(|it: char| it.is_ascii_digit()).unwrap_or(rest.len())];
        let digits: String = rest[text.len()..].chars().take_while(is_digit).collect();
        rest = &rest[text.len() + digits.len()..];
        key.push(match digits.parse() {
            Ok(number) => (text.to_owned(), Some(number)),
            // Not a number, or one of more than nineteen digits.
            Err(_) => (format!("{text}{digits}"), None),
        });
    }
    key
}
