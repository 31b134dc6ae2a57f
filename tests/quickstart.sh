#!/usr/bin/env bash
# Tests ./quickstart on a machine without packages, with substitutes for the tools that would change the machine.
set -euo pipefail
quickstart=$1
stage=$(mktemp -d)
trap 'rm -rf "$stage"' EXIT
mkdir -p "$stage/bin" "$stage/tree/build"
cp "$quickstart" "$stage/tree/quickstart"
export CALLS="$stage/calls" ASSUR_DB= SUMMARY= UNKNOWN=

# stand_in NAME 'script': makes a program with that name that records its calls.
stand_in() {
  printf '#!/bin/bash\necho "%s $*" >>"$CALLS"\n%s\n' "$1" "${2:-}" >"$stage/bin/$1"
  chmod +x "$stage/bin/$1"
}
stand_in cmake 'if [[ $* == "--preset release" ]]; then printf "%s\n" "$SUMMARY"; fi'
stand_in ctest
stand_in apt-get
stand_in apt-cache 'for unknown in $UNKNOWN; do [[ $2 == "$unknown" ]] && exit 0; done; echo "$2 | 1.0"'
stand_in sudo 'exit 1'
stand_in dpkg-query 'for absent in $ABSENT; do [[ ${!#} == "$absent" ]] && exit 1; done; echo "installed "'
printf '#!/bin/bash\necho "assur $*" >>"$CALLS"\n' >"$stage/tree/build/assur"
chmod +x "$stage/tree/build/assur"

# play USER-ID ABSENT ARGUMENTS...: sets status, output and calls.
play() {
  stand_in id "echo $1"
  export ABSENT=$2
  : >"$CALLS"
  status=0
  output=$(PATH="$stage/bin:$PATH" "$stage/tree/quickstart" "${@:3}" 2>&1 </dev/null) || status=$?
  calls=$(grep -vE '^(dpkg-query|apt-cache|id) ' "$CALLS" || true)
}
fail() { printf 'FAILED: %s\nstatus %s\n%s\ncalls:\n%s\n' "$1" "$status" "$output" "$calls"; exit 1; }
contains() { [[ $1 == *"$2"* ]]; }

play 1000 ""
[[ $status -eq 0 ]] || fail "nothing missing: it builds without root"
! contains "$calls" apt-get || fail "nothing missing: apt-get is left alone"
contains "$calls" "assur tune --profile quick" || fail "it tunes"
contains "$calls" "assur plan stewart" || fail "it shows the plan"
contains "$calls" "assur run stewart --reference" || fail "it runs the Stewart platform"

play 1000 "" test
[[ $status -eq 0 && ${calls##*$'\n'} == ctest* ]] || fail "test: ctest has the last word"

play 1000 "libcli11-dev libeigen3-dev"
[[ $status -eq 1 ]] || fail "required packages missing without root: status 1"
contains "$output" "apt-get install libeigen3-dev libcli11-dev" || fail "it names what to install"
contains "$output" "CLI11 2.1" || fail "it names the libraries as they are called elsewhere"
! contains "$calls" cmake || fail "it does not build"

play 1000 "libboost-dev"
[[ $status -eq 0 ]] && contains "$output" libboost-dev || fail "an optional package missing: said, and it goes on"

SUMMARY='-- assur
  found    hwy 1.0.3: SIMD lanes
  without  UMFPACK: backend umfpack, under the GPL (-D ASSUR_WITH_GPL=ON)
  without  KLU: backend klu (switched off by CMAKE_DISABLE_FIND_PACKAGE_KLU)
  without  Boost: reference solutions (version 1.70 was found, 1.74 or later is needed)
  without  Python3: the Python package (Debian: apt install python3-dev python3-numpy)
  without  tinyxml2: models (Debian: apt install libtinyxml2-dev)'
play 1000 "python3-numpy"
expected='Built without Boost: reference solutions (version 1.70 was found, 1.74 or later is needed)
Built without tinyxml2: models (CMake does not find libtinyxml2-dev, installed here)'
[[ $(grep '^Built without' <<<"$output") == "$expected" ]] || fail "it names installed packages that CMake does not use"
SUMMARY=

if grep -q '^ID=debian' /etc/os-release; then
  play 0 "libgtest-dev cmake" test
  expected=$'apt-get -q update\napt-get -q install -y --no-install-recommends cmake libgtest-dev'
  contains "$calls" "$expected" || fail "as root: installs what is missing and nothing else"
  UNKNOWN="libboost-dev" play 0 "libboost-dev cmake"
  contains "$calls" $'--no-install-recommends cmake\n' || fail "leaves out what this release does not have"
  contains "$output" "lacks libboost-dev, Boost" || fail "and says so"
fi

play 0 "" tools
[[ $status -eq 0 && -z $calls ]] || fail "tools: builds nothing"

play 0 "" bogus
[[ $status -eq 2 ]] && contains "$output" usage || fail "a wrong argument: usage, status 2"
play 0 "" --help
[[ $status -eq 0 ]] && contains "$output" usage || fail "--help: usage, status 0"
echo "quickstart does what it says"
