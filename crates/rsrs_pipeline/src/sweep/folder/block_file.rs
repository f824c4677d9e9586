//! A finished block as a file: its replicates, and a digest that shows whether it is whole.
//!
//! Numbers are little-endian: magic, digest of the sweep, number of the block, its pieces (count;
//! cell, first replicate and end of each), one row for each replicate, digest of all of that. A file
//! that was torn, or belongs to another sweep, reads as nothing and is made again.

use rsrs_core::digest::Digest;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::order::{OrderParameters, Parameter};
use rsrs_core::judge::phase::Phase;
use rsrs_sim::sweep::{Block, ReplicateOutcome};

const MAGIC: &[u8; 8] = b"rsrsblk3";

/// Which sweep a block belongs to, and which of its blocks it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockId {
    /// Digest of the sweep.
    pub sweep: u64,
    /// Number of the block, from 0.
    pub number: u64,
    /// What its replicates were judged for.
    pub behaviour: Behaviour,
}

/// The bytes of a block's file.
pub fn encode(place: BlockId, block: &Block, outcomes: &[ReplicateOutcome]) -> Vec<u8> {
    let mut bytes = header(place, block);
    let parameters = Parameter::of_behaviour(place.behaviour);
    for outcome in outcomes {
        encode_row(outcome, &parameters, &mut bytes);
    }
    let digest = digest(&bytes);
    bytes.extend(digest.to_le_bytes());
    bytes
}

/// The replicates of a block's file; `None` if it is not exactly this block's, and whole.
pub fn decode(place: BlockId, block: &Block, bytes: &[u8]) -> Option<Vec<ReplicateOutcome>> {
    let (content, found) = bytes.split_last_chunk::<8>().map(|(content, end)| (content, *end))?;
    let rows = content.strip_prefix(header(place, block).as_slice())?;
    let n_rows = usize::try_from(block.n_rows()).ok()?;
    let parameters = Parameter::of_behaviour(place.behaviour);
    let n_bytes = 1 + presence_bytes(&parameters) + 8 * parameters.len();
    if u64::from_le_bytes(found) != digest(content) || rows.len() != n_rows * n_bytes {
        return None;
    }
    let rows = block.rows().zip(rows.chunks_exact(n_bytes));
    let phases = place.behaviour.phases();
    rows.map(|(which, bytes)| decode_row(which, bytes, (phases, &parameters))).collect()
}

fn header(place: BlockId, block: &Block) -> Vec<u8> {
    let pieces = block
        .pieces
        .iter()
        .flat_map(|piece| [piece.cell as u64, piece.replicates.start, piece.replicates.end]);
    let words = [place.sweep, place.number, block.pieces.len() as u64].into_iter().chain(pieces);
    MAGIC.iter().copied().chain(words.flat_map(u64::to_le_bytes)).collect()
}

fn digest(bytes: &[u8]) -> u64 {
    let mut digest = Digest::new("block");
    digest.bytes(bytes);
    digest.value()
}

/// How many bytes of a row state which of its numbers there are; they stand between phase and numbers.
fn presence_bytes(parameters: &[Parameter]) -> usize {
    parameters.len().div_ceil(8)
}

fn encode_row(outcome: &ReplicateOutcome, parameters: &[Parameter], bytes: &mut Vec<u8>) {
    bytes.push(u8::try_from(outcome.phase.place()).expect("phases are few"));
    let numbers: Vec<Option<f64>> =
        parameters.iter().map(|parameter| parameter.value(&outcome.evidence)).collect();
    let present =
        numbers.iter().enumerate().map(|(bit, number)| u64::from(number.is_some()) << bit);
    bytes.extend(&present.sum::<u64>().to_le_bytes()[..presence_bytes(parameters)]);
    bytes.extend(numbers.iter().flat_map(|number| number.unwrap_or(0.0).to_le_bytes()));
}

fn decode_row(
    (cell, replicate): (usize, u64),
    bytes: &[u8],
    (phases, parameters): (&[Phase], &[Parameter]),
) -> Option<ReplicateOutcome> {
    let phase = *phases.get(usize::from(bytes[0]))?;
    let (present, numbers) = bytes[1..].split_at(presence_bytes(parameters));
    let (numbers, _) = numbers.as_chunks::<8>();
    let mut evidence = OrderParameters::default();
    for (bit, (parameter, number)) in parameters.iter().zip(numbers).enumerate() {
        if present[bit / 8] >> (bit % 8) & 1 == 1 {
            parameter.set(&mut evidence, f64::from_le_bytes(*number));
        } else if parameter.value(&evidence).is_some() {
            // One that every window has.
            return None;
        }
    }
    Some(ReplicateOutcome { cell, replicate, phase, evidence })
}

#[cfg(test)]
mod tests {
    use rsrs_sim::sweep::CellReplicates;

    use super::*;

    const PLACE: BlockId = BlockId { sweep: 1, number: 2, behaviour: Behaviour::MILLING };

    fn block() -> Block {
        let piece = |cell, replicates| CellReplicates { cell, replicates };
        Block { pieces: vec![piece(3, 5..7), piece(4, 0..1)] }
    }

    fn outcomes() -> Vec<ReplicateOutcome> {
        let outcome = |((cell, replicate), phase): ((usize, u64), Phase)| ReplicateOutcome {
            cell,
            replicate,
            phase,
            evidence: OrderParameters {
                lost: (replicate == 5).then_some(0.25),
                blocked: 0.01,
                stuck: 0.02,
                rotation: 0.03,
                orbit: 0.04,
                fatness: 0.05,
                tangentness: 0.06,
                circliness: 0.07,
                mean_radius_m: 0.08 + replicate as f64,
                contact_onsets_per_s: (cell == 3).then_some(-0.0),
                circliness_ceiling: 0.10,
                clustered: (cell == 4).then_some(0.11),
                ..OrderParameters::default()
            },
        };
        block().rows().zip(Phase::BUILT_IN).map(outcome).collect()
    }

    #[test]
    fn a_block_reads_back_to_the_bit() {
        let found = decode(PLACE, &block(), &encode(PLACE, &block(), &outcomes()));

        assert_eq!(found, Some(outcomes()));
    }

    #[test]
    fn a_row_of_all_measures_that_there_are_reads_back() {
        let parameters: Vec<Parameter> = Parameter::all().collect();
        let mut outcome = outcomes().remove(0);
        for (number, parameter) in parameters.iter().enumerate() {
            parameter.set(&mut outcome.evidence, number as f64);
        }
        let mut bytes = Vec::new();

        encode_row(&outcome, &parameters, &mut bytes);

        let which = (outcome.cell, outcome.replicate);
        assert_eq!(decode_row(which, &bytes, (&Phase::BUILT_IN, &parameters)), Some(outcome));
    }

    #[test]
    fn a_block_that_was_torn_anywhere_or_has_one_wrong_bit_is_not_read() {
        let whole = encode(PLACE, &block(), &outcomes());

        for end in 0..whole.len() {
            assert_eq!(decode(PLACE, &block(), &whole[..end]), None, "{end} bytes");
        }
        for bit in 0..8 * whole.len() {
            let mut damaged = whole.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(decode(PLACE, &block(), &damaged), None, "bit {bit}");
        }
    }

    #[test]
    fn a_block_of_another_sweep_or_place_is_not_read() {
        let bytes = encode(PLACE, &block(), &outcomes());
        let mut shifted = block();
        shifted.pieces[0].replicates = 6..8;

        assert_eq!(decode(BlockId { sweep: 2, ..PLACE }, &block(), &bytes), None);
        assert_eq!(decode(BlockId { number: 3, ..PLACE }, &block(), &bytes), None);
        assert_eq!(decode(PLACE, &shifted, &bytes), None);
    }
}
