//! The vector units of machines, behind one trait: AVX2, AVX-512, and plain Rust over arrays of four.
//!
//! Plain Rust over arrays of 8 and 16 judges at 0.94 × the rate of AVX2's intrinsics and at 0.87 × that of
//! AVX-512's: see "Why intrinsics" in `docs/BENCHMARKS.md`.

#![expect(
    clippy::inline_always,
    reason = "what is not inlined into the function of a vector unit does without its instructions"
)]

#[cfg(target_arch = "x86_64")]
pub mod avx2;
#[cfg(target_arch = "x86_64")]
pub mod avx512;
pub mod portable;
pub mod simd;
#[cfg(target_arch = "x86_64")]
mod x86;

/// Does work of one world with the vectors that most machines have, where plain Rust is turned into
/// them.
pub fn with_vectors<W: simd::Work>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(unit) = avx2::Avx2::find() {
        return simd::Simd::vectorize(unit, work);
    }
    work.run()
}
