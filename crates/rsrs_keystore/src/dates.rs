//! Moments, as people and documents of XML read them.

use std::time::Duration;

use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::TimeZone;

/// A moment as text.
pub(crate) fn date(since_1970: Duration) -> String {
    let seconds = i64::try_from(since_1970.as_secs()).unwrap_or(i64::MAX);
    Timestamp::from_second(seconds).map_or_else(|_| "no date".to_owned(), |date| date.to_string())
}

/// A date in UTC, as XML has it.
pub(crate) fn xml_date(since_1970: Duration) -> Option<String> {
    let timestamp = Timestamp::from_second(i64::try_from(since_1970.as_secs()).ok()?).ok()?;
    Some(timestamp.to_zoned(TimeZone::UTC).datetime().to_string())
}

/// A date as XML has it, since 1970; without a time zone it is in UTC.
pub(crate) fn moment(text: &str) -> Option<Duration> {
    let in_utc = || {
        let civil: DateTime = text.parse().ok()?;
        Some(civil.to_zoned(TimeZone::UTC).ok()?.timestamp())
    };
    let timestamp = text.parse::<Timestamp>().ok().or_else(in_utc)?;
    u64::try_from(timestamp.as_second()).ok().map(Duration::from_secs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_of_xml_are_understood_with_and_without_a_time_zone() {
        let noon = Some(Duration::from_secs(1_767_268_800));

        assert_eq!(moment("2026-01-01T12:00:00"), noon);
        assert_eq!(moment("2026-01-01T12:00:00Z"), noon);
        assert_eq!(moment("2026-01-01T14:00:00+02:00"), noon);
        assert_eq!(moment("tomorrow"), None);
    }
}
