//! README, the READMEs of the crates and the guide of `docs/guide`, whose programs run as tests of this documentation.

macro_rules! chapters {
    ($($name:ident $file:literal),* $(,)?) => { $(#[doc = include_str!($file)] pub mod $name {})* };
}

chapters! {
    readme "../../README.md",
    audit "../../crates/audit/README.md",
    certificate "../../crates/certificate/README.md",
    core "../../crates/core/README.md",
    curved "../../crates/curved/README.md",
    numbers "../../crates/numbers/README.md",
    oracle "../../crates/oracle/README.md",
    paper "../../crates/paper/README.md",
    scene "../../crates/scene/README.md",
    solver "../../crates/solver/README.md",
    evaluate "../../docs/guide/evaluate.md",
    trust "../../docs/guide/trust.md",
    derivatives "../../docs/guide/derivatives.md",
    gradients "../../docs/guide/gradients.md",
    scenes "../../docs/guide/scenes.md",
    heat "../../docs/guide/heat.md",
    solve "../../docs/guide/solve.md",
    ground_truth "../../docs/guide/ground-truth.md",
    speed "../../docs/guide/speed.md",
}
