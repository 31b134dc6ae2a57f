#!/bin/sh
# Makes a folder with scaling_bench and all libraries that it needs, including the C library. The program then runs on
# any Linux of the same processor family, without further packages.
#
#   bench/pack_scaling.sh [BUILD [FOLDER]]     build/ and scaling/ unless told otherwise
#
# On the other machine: FOLDER/run --csv scaling.csv
set -eu
program=${1:-build}/bench/scaling_bench
folder=${2:-scaling}
[ -x "$program" ] || { echo "$program is not there; build it first" >&2; exit 3; }
[ ! -e "$folder" ] || { echo "$folder is there already; name another folder" >&2; exit 2; }

# Takes the file from each line of ldd: "name => file (address)", or "file (address)" for the loader.
libraries=$(ldd "$program" | sed -n 's/.*=> \(\/[^ ]*\) .*/\1/p; s/^[[:space:]]*\(\/[^ ]*\) .*/\1/p')
loader=$(echo "$libraries" | grep '/ld[-.]') || { echo "$program has no loader; is it linked statically?" >&2; exit 3; }

mkdir -p "$folder/lib"
for library in $libraries; do cp -L "$library" "$folder/lib/"; done
cp "$program" "$folder/"
strip "$folder/scaling_bench" 2>/dev/null || true  # smaller, where binutils are

cat >"$folder/run" <<END
#!/bin/sh
# Runs scaling_bench with the libraries beside it; takes its options.
here=\$(cd "\$(dirname "\$0")" && pwd)
exec "\$here/lib/$(basename "$loader")" --library-path "\$here/lib" "\$here/scaling_bench" "\$@"
END
chmod +x "$folder/run"
du -sh "$folder"
