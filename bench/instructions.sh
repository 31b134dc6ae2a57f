#!/bin/sh
# Instructions per step of some hot loops, counted by callgrind. The counts are the same on every machine that runs the
# same code, so that counts before and after a change can be compared. valgrind emulates an AVX2 processor, so that the
# AVX2 code is counted.
#
#   bench/instructions.sh [BUILD [STEPS]]     build/ and 200 steps unless told otherwise
set -eu
program=${1:-build}/bench/hot_loops
steps=${2:-200}
[ -x "$program" ] || { echo "$program is not there; build it first" >&2; exit 3; }
command -v valgrind >/dev/null || { echo "valgrind is missing (Debian: apt install valgrind)" >&2; exit 3; }
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT

# count SCENE STRATEGY
count() {
  if ! valgrind --tool=callgrind --callgrind-out-file="$work/out" --toggle-collect=run_hot_loop \
      "$program" "$1" "$2" "$steps" >"$work/log" 2>&1; then
    printf '%-25s %-44s cannot run: %s\n' "$1" "$2" "$(grep -v '^==' "$work/log" | head -1 | cut -c1-100)"
    return
  fi
  total=$(sed -n 's/^\(summary\|totals\): *\([0-9]*\).*/\2/p' "$work/out" | head -1)
  if [ "$total" = 0 ]; then  # valgrind 3.19 does not know every instruction of AVX2 (vmovq between registers)
    printf '%-25s %-44s cannot run: %s\n' "$1" "$2" "$(grep -m 1 'unhandled instruction' "$work/log" | cut -c1-60)"
    return
  fi
  printf '%-25s %-44s %12d\n' "$1" "$2" $((total / steps))
}

printf '%-25s %-44s %12s\n' scene strategy instructions
for solver in klu lanes:8 lanes:8+once; do count stewart "groups/$solver+predict=hermite:5"; done
for solver in eigen lanes:8 lanes:8+once; do count stewart "irreducible/$solver+predict=hermite:5"; done
for scene in four_bar slider_crank; do count "$scene" "irreducible/lanes+predict=hermite:5"; done
for solver in eigen klu lanes lanes+once; do count four_bar:100 "irreducible/$solver+predict=hermite:5"; done

# Mechanisms written with joints and by hand.
for name in four_bar slider_crank slider_crank_end watt stephenson quick_return excavator chain rssr rscr rssp hexapod \
    hexapod_inverse delta delta_translating wishbone spherical; do
  for way in joints by_hand; do count "$way=$name" auto; done
done
