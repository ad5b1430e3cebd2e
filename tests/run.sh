#!/usr/bin/env bash
# The whole test suite, ray hits against Embree among it; what it needs and the machine lacks is brought first.
# Arguments go to `cargo test`: tests/run.sh embree -- --nocapture
set -euo pipefail
exec "$(dirname "${BASH_SOURCE[0]}")/with-embree.sh" cargo test --profile tests --features bench "$@"
