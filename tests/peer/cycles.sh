#!/usr/bin/env bash
# Renders two scenes, two geometries and both illuminations with equilux-render and with Blender's Cycles, and compares the
# pictures region by region; then shows that the comparison finds pictures that are too bright.
#   cycles.sh BIN-FOLDER OUT-FOLDER [TIMES]    TIMES as many pictures of each renderer (1)
# Leaves with 1 if they disagree anywhere or if a mutant is not found. Pictures that are there are not made again.
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/../.."
bin=$1 out=$2 times=${3:-1}
# The noise of a region comes from its number of paths; more pixels would only cost more subpixel positions, of which there
# must be many: ours are fixed, and Cycles' are random.
width=128 height=96 positions=64 paths=1024 threads=2
command -v blender >/dev/null || { echo "$0: blender is missing: apt-get install --no-install-recommends blender" >&2; exit 1; }

# render_ours SCENE FAMILY FOLDER SEED OBJECT-OPTIONS...
render_ours() {
  local scene=$1 family=$2 folder=$3 seed=$4 seconds
  shift 4
  TIMEFORMAT='%R %U'
  seconds=$({ time "$bin/equilux-render" image "$scene" "$@" --width $width --height $height --positions $positions \
    --paths $paths --seed "$seed" --threads $threads --out "$folder/$family-ours-$seed.exr" >/dev/null 2>&1; } 2>&1)
  echo "$family ours $seed $seconds" >>"$folder/seconds.txt"
}

# render_cycles FAMILY FOLDER FIRST-SEED PICTURES SAMPLES
render_cycles() {
  blender -b --python-exit-code 1 --python "$2/$1.py" -- --samples "$5" --seed "$3" --seeds "$4" --threads $threads \
    --out "$2/$1-cycles-{}.exr" |
    sed -unE "s|^rendered .*-cycles-([0-9]+)\.exr: seconds (.*) processor (.*)$|$1 cycles \1 \2 \3|p" >>"$2/seconds.txt"
}

# render_case SCENE FOLDER GEOMETRY ILLUMINATION OURS THEIRS SAMPLES
render_case() {
  local folder=$2 family=$3-LG-$4-ref-v0 have seed
  local object=(--geometry "$3" --material LG --illumination "$4" --view v0)
  "$bin/equilux-render" export "$1" "${object[@]}" --width $width --height $height --out "$folder/$family.py" >/dev/null
  have=$(grep -c "^$family ours " "$folder/seconds.txt" || true)
  for seed in $(seq $((have + 1)) "$5"); do render_ours "$1" "$family" "$folder" "$seed" "${object[@]}"; done
  have=$(grep -c "^$family cycles " "$folder/seconds.txt" || true)
  if [ "$have" -lt "$6" ]; then render_cycles "$family" "$folder" $((have + 1)) $(($6 - have)) "$7"; fi
}

# compare_scene SCENE NAME OURS THEIRS SAMPLES: half the level each, .01 over both scenes.
compare_scene() {
  local folder=$out/$2 geometry illumination
  mkdir -p "$folder"
  touch "$folder/seconds.txt"
  for geometry in G0 G2; do
    for illumination in ind dir; do
      render_case "$1" "$folder" "$geometry" "$illumination" $(($3 * times)) $(($4 * times)) "$5"
    done
  done
  printf '\n# %s: %d pictures of ours with %d paths a pixel, %d of Cycles with %d\n' "$2" $(($3 * times)) $paths \
    $(($4 * times)) "$5"
  "$bin/peer_compare" "$1" "$folder" --level 0.005 || failed=1
}

# expect_found SCENE NAME SCALE: our pictures times SCALE must differ.
expect_found() {
  if "$bin/peer_compare" "$1" "$out/$2" --level 0.005 --scale "$3" >"$out/mutant.txt"; then
    echo "mutant NOT FOUND: our pictures of $2 times $3" >&2
    failed=1
    return
  fi
  echo "mutant found: our pictures of $2 times $3: $(tail -n 1 "$out/mutant.txt")"
}

failed=0
blender --version | head -n 1
echo "$width x $height pixels, our $positions subpixel positions, $threads threads"
compare_scene tests/peer/room.json room 16 24 320
compare_scene stimuli/scenes/cafe.json cafe 6 24 400
echo
expect_found tests/peer/room.json room 1.005
expect_found stimuli/scenes/cafe.json cafe 1.01
exit $failed
