# For the scripts in this folder: runs parts one after the other, and reports their times. shellcheck shell=bash
rows=() current=

# part NAME COMMAND...: runs the command and records its time. If it fails, the script ends and names the part.
part() {
  current=$1
  local from=$SECONDS
  printf '\n== %s\n' "$current"
  shift
  "$@"
  rows+=("$(printf '  %-20s %5d s' "$current" $((SECONDS - from)))")
  printf '== %s: passed, %d s\n' "$current" $((SECONDS - from))
  current=
}

table() {
  local status=$?
  printf '\n%s\n' "${rows[@]}" | sed '1!{/^$/d}'
  [[ -z $current ]] || printf '  %-20s FAILED\n' "$current"
  printf '  %-20s %5d s\n' total "$SECONDS"
  exit "$status"
}
trap table EXIT

# build PRESET TARGETS...
build() {
  cmake --preset "$1"
  cmake --build --preset "$1" --parallel "$(nproc)" ${2:+--target "${@:2}"}
}
