#!/bin/sh
# Takes the built command and its tests to a machine with an NVIDIA GPU, measures there for eight minutes at most, and
# brings one folder back: contract tests of the GPU backends, samples of the tuner, table 5 of the paper, `check --quick`.
#
#   bench/on_device.sh HOST [BUILD [RESULTS]]     HOST: a name for ssh, or "here"; build/ and device/ unless told otherwise
#
# The other machine needs x86-64 Linux with a C library as new as this one's, the driver, and the libraries of CUDA; its
# LD_LIBRARY_PATH or ldconfig names their folder.
set -eu
host=${1:?"usage: bench/on_device.sh HOST [BUILD [RESULTS]]; HOST: a name for ssh, or \"here\""}
build=${2:-build}
results=${3:-device}
for program in "$build/assur" "$build/tests/backends_test"; do
  [ -x "$program" ] || { echo "$program is not there; build it first" >&2; exit 3; }
done
[ ! -e "$results" ] || { echo "$results is there already; name another folder" >&2; exit 2; }

packed=$(mktemp -d)
trap 'rm -rf "$packed"' EXIT
mkdir "$packed/lib"
for program in "$build/assur" "$build/tests/backends_test"; do
  # All libraries except the C library, which must fit the loader of the other machine.
  for library in $(ldd "$program" | sed -n 's/.*=> \(\/[^ ]*\) .*/\1/p'); do
    case ${library##*/} in
      libc.so.* | libm.so.* | libdl.so.* | librt.so.* | libpthread.so.* | libcu*) ;;
      *) cp -L "$library" "$packed/lib/" ;;
    esac
  done
  cp "$program" "$packed/"
  strip "$packed/${program##*/}" 2>/dev/null || true  # smaller, where binutils are
done

cat >"$packed/run" <<'END'
#!/bin/sh
# Runs everything in this folder and writes to results/. Each part has a limit in seconds, which sum up to 480.
cd "$(dirname "$0")"
export LD_LIBRARY_PATH="$PWD/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}" ASSUR_DB="$PWD/results/tuning.db"
mkdir -p results
part() {  # NAME SECONDS COMMAND...
  name=$1 limit=$2 begin=$(date +%s)
  shift 2
  status=0
  timeout "$limit" "$@" >"results/$name.txt" 2>&1 || status=$?
  echo "$name: status $status, $(($(date +%s) - begin)) s of at most $limit" | tee -a results/summary.txt
}
part backends 20 ./assur backends
part contract 90 ./backends_test --gtest_filter='Cusolver*:Magma*:*cusolver*:*magma*'
part tune 70 ./assur tune --budget 50 --csv results/samples.csv
part report 200 ./assur report --quick --budget 130 --out results/report
part check 100 ./assur check --quick
END
chmod +x "$packed/run"

if [ "$host" = here ]; then
  "$packed/run"
  cp -r "$packed/results" "$results"
else
  folder=$(ssh "$host" mktemp -d)
  tar -C "$packed" -cz . | ssh "$host" "tar -C $folder -xz && $folder/run"
  mkdir "$results"
  ssh "$host" "tar -C $folder/results -cz . && rm -rf $folder" | tar -C "$results" -xz
fi
echo "results are in $results"
