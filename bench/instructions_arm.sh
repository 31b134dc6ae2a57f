#!/usr/bin/env bash
# Instructions per step of some hot loops on ARM beside x86-64, counted by qemu-user: the difference of two runs with
# different numbers of steps. Emulation says nothing about times. qemu emulates AVX2, so that the AVX2 code of x86-64 is
# counted, NEON on 64-bit ARM, and on 32-bit ARM code without vectors.
#
#   bench/instructions_arm.sh [BUILD...]      build, build-arm64 and build-armhf unless told otherwise; .ci/arm builds
#                                             the programs for ARM: cmake --build --preset arm64 --target hot_loops
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
if [[ $# -eq 0 ]]; then set -- build build-arm64 build-armhf; fi
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT
command -v qemu-x86_64 qemu-aarch64 qemu-arm >/dev/null ||
  { echo "qemu-user is missing (Debian: apt install qemu-user)" >&2; exit 3; }
cc -O2 -Wall -shared -fPIC "$here/count_instructions.c" -o "$work/count.so"

# emulated BUILD ARGUMENTS...: runs hot_loops of a build, and prints the number of its instructions.
emulated() {
  local build=$1 triple emulator
  shift
  case $(readelf -h "$build/bench/hot_loops" | sed -n 's/.*Machine: *//p') in
    *X86-64) emulator=(qemu-x86_64 -cpu max) ;;
    AArch64) emulator=(qemu-aarch64) triple=aarch64-linux-gnu ;;
    ARM) emulator=(qemu-arm) triple=arm-linux-gnueabihf ;;
    *) echo "$build/bench/hot_loops is not there, or for another machine" >&2; return 3 ;;
  esac
  if [[ -v triple ]]; then
    emulator+=(-L "/usr/$triple" -E "LD_LIBRARY_PATH=/usr/$triple/lib:$build/packages/usr/lib/$triple")
  fi
  "${emulator[@]}" -plugin "$work/count.so" "$build/bench/hot_loops" "$@" 2>"$work/log" >/dev/null ||
    { echo "cannot run: $(head -1 "$work/log")" >&2; return 1; }
  sed -n 's/^instructions //p' "$work/log"
}

# count SCENE STRATEGY STEPS [ITERATIONS]: a row with the instructions per step in each build.
count() {
  printf '%-34s %-40s' "$1" "$2"
  for build in "${builds[@]}"; do
    local few many
    if few=$(emulated "$build" "$1" "$2" 1 "${@:4}") && many=$(emulated "$build" "$1" "$2" $(($3 + 1)) "${@:4}"); then
      printf ' %14d' $(((many - few) / $3))
    else
      printf ' %14s' -
    fi
  done
  echo
}

builds=("$@")
printf '%-34s %-40s' scene strategy
printf ' %14s' "${builds[@]##*/}"
echo
for scene in four_bar slider_crank; do count "$scene" irreducible/lanes+predict=hermite:5 2000; done
for solver in klu lanes:8; do count stewart "groups/$solver+predict=hermite:5" 500; done
for solver in eigen lanes:8; do count stewart "irreducible/$solver+predict=hermite:5" 500; done
count four_bar:100 irreducible/lanes+predict=hermite:5 200

# Table 4 of the paper: 20 iterations. Arguments: unknowns of the terminal and of a group, steps with a dense solver.
ring() {
  count "rings:legs=6,n=$2,terminal=$1" groups/eigen "$3" 20
  count "rings:legs=6,n=$2,terminal=$1" groups/lanes:8 50 20
}
ring 12 18 20
ring 24 36 5
ring 48 72 2
ring 96 144 1
