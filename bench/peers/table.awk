#!/usr/bin/awk -f
# The table of README.md from a CSV of peers.sh: table.awk peers.csv
function largest(a, b, c) { return a + 0 > b + 0 ? (a + 0 > c + 0 ? a : c) : (b + 0 > c + 0 ? b : c) }
function time(us) {
  if (us >= 1000) return sprintf("%d,%03d", int(us / 1000 + 0.0005), us % 1000 + 0.5)
  return sprintf(us < 9.995 ? "%.2f" : us < 99.95 ? "%.1f" : "%.0f", us)
}
BEGIN {
  FS = ","
  mechanisms = split("four_bar:1 four_bar:10 four_bar:100 stewart", mechanism, " ")
  split("four-bar;10 four-bars in series;100 four-bars in series;Stewart platform", title, ";")
}
NR > 1 && ($3 == 3 || $1 ~ /^libslvs/) {
  split($1, peer, " ")
  if (!(peer[1] in name)) order[++peers] = peer[1]
  name[peer[1]] = $1 ($3 == 1 ? " (positions)" : "")
  cells[$2, peer[1]] = time(1e6 * $5) " µs | " sprintf("%.0e", largest($8, $9, $10))
}
END {
  head = "| mechanism |"
  rule = "|---|"
  for (p = 1; p <= peers; ++p) head = head " " name[order[p]] " | error |"
  for (p = 1; p <= peers; ++p) rule = rule "---|---|"
  print head "\n" rule
  for (m = 1; m <= mechanisms; ++m) {
    row = "| " title[m] " |"
    for (p = 1; p <= peers; ++p) row = row " " cells[mechanism[m], order[p]] " |"
    print row
  }
}
