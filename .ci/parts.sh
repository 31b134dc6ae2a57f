# For the scripts in this folder: runs parts one after the other, and reports their times. shellcheck shell=bash
rows=() current=

# part NAME [MINUTES] COMMAND...: runs the command and records its time, beside its budget of MINUTES on two slow cores.
# If the command fails, or takes more than one and a half times its budget, the script ends and names the part.
part() {
  local budget= from=$SECONDS of=
  current=$1
  shift
  if [[ $1 =~ ^[0-9]+$ ]]; then
    budget=$(($1 * 60))
    of=" of $budget"
    shift
  fi
  printf '\n== %s\n' "$current"
  "$@"
  local seconds=$((SECONDS - from))
  rows+=("$(printf '  %-20s %5d s%s' "$current" "$seconds" "$of")")
  if [[ -n $budget ]] && ((2 * seconds > 3 * budget)); then
    printf '== %s: %d s%s s, more than one and a half times its budget\n' "$current" "$seconds" "$of"
    exit 1
  fi
  printf '== %s: passed, %d s\n' "$current" "$seconds"
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
