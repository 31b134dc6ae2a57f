#!/usr/bin/env bash
# Runs the blocks of one page in order in a new folder, then the programs of the page.
#
#   run.sh ASSUR SOURCES BLOCKS PROGRAMS...
set -euo pipefail
assur=$1 sources=$2 blocks=$3
shift 3
stage=$(mktemp -d)
trap 'rm -rf "$stage"' EXIT
mkdir "$stage/bin" "$stage/build" "$stage/home"
ln -s "$assur" "$stage/bin/assur"
ln -s "$assur" "$stage/build/assur"
ln -s "$sources/scenes" "$sources/examples" "$stage"
export PATH="$stage/bin:$PATH" HOME="$stage/home" ASSUR_DB=
unset XDG_DATA_HOME
cd "$stage"

# Checks for each `assur COMMAND ... --option ...` of a block that the help has the command and its options.
options_exist() {
  local call words command help word
  sed -E 's/ +#.*//; s/(&&|\||;)/\n/g' "$1" | sed -nE 's,^(.*[ /])?assur +,,p' | while read -r call; do
    read -ra words <<<"$call"
    command=${words[0]}
    if [[ $command == db ]]; then command="db ${words[1]}"; fi
    help=$(assur $command --help) || return 1
    for word in "${words[@]}"; do
      if [[ $word == --* ]] && ! grep -qE -- "^ +(-.,)?$word( |$)" <<<"$help"; then
        echo "assur $call: there is no option $word"
        return 1
      fi
    done
  done
}

while read -r what file; do
  echo "== $what $file"
  case $what in
    scene)
      tail -n +2 "$blocks/$file" >"$file"
      assur inspect "$file" --quiet >/dev/null
      ;;
    run)
      bash -euo pipefail "$blocks/$file" >output
      cat output
      ;;
    same) diff output <(tail -n +2 "$blocks/$file") ;;
    exists) options_exist "$blocks/$file" ;;
  esac
done <"$blocks/order"
for program in "$@"; do
  echo "== program ${program##*/}"
  "$program"
done
