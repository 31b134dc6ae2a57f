#!/usr/bin/env bash
# Runs the programs of the comparison in turns and merges their lines: medians over the rounds, and their spread.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: peers.sh [--quick] [--rounds N] [--csv FILE] [BUILD]

  Processor time of a step of Simbody, libslvs and assur on the same mechanisms, whichever of them BUILD (default: build) has.
  Answers are held against the closed form in quad precision; the exit status is 1 if one is further off than 1e-9, or missing.
TEXT
}

rounds=7 csv= build=build status=0
# Mechanism and steps: large ones take Simbody a long time.
mechanisms=("four_bar:1 1000" "four_bar:10 1000" "four_bar:100 50" "stewart 1000")
while [[ $# -gt 0 ]]; do
  case $1 in
    --quick) rounds=1 mechanisms=("four_bar:1 50" "four_bar:10 10" "stewart 20") ;;
    --rounds) rounds=$2 && shift ;;
    --csv) csv=$2 && shift ;;
    --help | -h) usage && exit ;;
    -*) usage >&2 && exit 2 ;;
    *) build=$1 ;;
  esac
  shift
done

folder=$build/bench/peers
[[ -x $folder/assur_peer ]] || { echo "no $folder/assur_peer: build it first" >&2 && exit 2; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 # all on one thread

for row in "${mechanisms[@]}"; do
  read -r mechanism steps <<<"$row"
  "$folder/assur_peer" reference "$mechanism" "$steps" >"$work/$mechanism"
done
for ((round = 1; round <= rounds; ++round)); do
  for row in "${mechanisms[@]}"; do
    read -r mechanism steps <<<"$row"
    for program in "assur_peer" "assur_peer positions" simbody_peer slvs_peer; do
      [[ -x $folder/${program%% *} ]] || continue
      # A peer that fails prints a message and has no line. shellcheck disable=SC2086 # a program and its argument
      $folder/$program "$mechanism" "$work/$mechanism" >>"$work/lines" || status=1
    done
  done
done

# seconds_per_step: median of the rounds; spread: median absolute deviation over it; errors: the worst.
awk -F, -v OFS=, '
  function median(values, n,    i, j, v) {
    for (i = 2; i <= n; ++i) {
      v = values[i]
      for (j = i - 1; j >= 1 && values[j] > v; --j) values[j + 1] = values[j]
      values[j + 1] = v
    }
    return n % 2 ? values[(n + 1) / 2] : (values[n / 2] + values[n / 2 + 1]) / 2
  }
  {
    key = $1 "," $2 "," $3
    if (!(key in count)) order[++keys] = key
    seconds[key, ++count[key]] = $5
    steps[key] = $4
    comment[key] = $9
    for (k = 6; k <= 8; ++k) if (!((key, k) in worst) || $k == "nan" || $k + 0 > worst[key, k] + 0) worst[key, k] = $k
  }
  END {
    print "peer", "mechanism", "levels", "steps", "seconds_per_step", "spread", "repetitions", "position_error",
      "velocity_error", "acceleration_error", "comment"
    for (i = 1; i <= keys; ++i) {
      key = order[i]
      n = count[key]
      for (j = 1; j <= n; ++j) all[j] = seconds[key, j]
      middle = median(all, n)
      for (j = 1; j <= n; ++j) all[j] = seconds[key, j] > middle ? seconds[key, j] - middle : middle - seconds[key, j]
      printf "%s,%s,%.4g,%.2g,%d,%s,%s,%s,%s\n", key, steps[key], middle, median(all, n) / middle, n, worst[key, 6],
        worst[key, 7], worst[key, 8], comment[key]
    }
  }' "$work/lines" | { read -r head; echo "$head"; sort -t, -k2,2V -k3,3nr -k5,5g; } >"$work/table"

[[ -z $csv ]] || cp "$work/table" "$csv"
awk -F, '
  BEGIN { split("position;and velocity;and acceleration", level, ";") }
  NR == 1 { printf "%-12s %-14s %-18s %14s %8s %12s %12s %12s\n", "mechanism", "peer", "levels", "us per step", "spread",
            "position", "velocity", "acceleration"; next }
  { printf "%-12s %-14s %-18s %14.2f %7.0f%% %12s %12s %12s\n", $2, $1, level[$3], 1e6 * $5, 100 * $6, $8, $9, $10
    for (k = 8; k <= 10; ++k) if ($k != "" && !($k + 0 < 1e-9 && $k != "nan")) wrong = 1 }
  END { exit wrong }' "$work/table" || status=1
exit $status
