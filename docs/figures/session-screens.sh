#!/usr/bin/env bash
# Photographs every screen of equilux-session for docs/sessions.md: sits through both experiments of a rendered study
# (studies/pocket, as ./run makes it) on a display of its own, by keys. Needs xvfb, xdotool and imagemagick.
#   docs/figures/session-screens.sh studies/pocket build/release/bin docs
set -euo pipefail
study=$(realpath "$1") bin=$(realpath "$2") out=$(realpath "$3")
work=$(mktemp -d)
folder=$work/pocket
cp -r "$study" "$folder"
rm -rf "$folder"/responses* "$folder"/selection* "$folder"/report

Xvfb -displayfd 3 -screen 0 1280x1024x24 3>"$work/display" 2>/dev/null &
server=$!
trap 'kill $server; rm -rf "$work"' EXIT
sleep 2
DISPLAY=:$(cat "$work/display")
export DISPLAY LIBGL_ALWAYS_SOFTWARE=1

shoot() { sleep 1.2; import -window root "$work/$1.png"; }
press() { for key in "$@"; do sleep .6; xdotool key "$key"; done; }
choose() { sleep .6; xdotool mousemove "$1" "$2" click 1; }

# The subject's screens, and what the experimenter sees before, between and after.
(cd "$work" && "$bin/equilux-session" run pocket >"$work/artifact.log" 2>&1) &
sleep 3
press F1 F3; shoot start
press Return; shoot setup
press F3; shoot setup-card
press Return; shoot consent
press Return; shoot questions
press Return; shoot questions-missing
choose 274 441; choose 274 567; press Return; shoot instructions
press space; shoot object
press space space space space; shoot example
press space space; shoot practice
press space; shoot artifact-practice
press Right; shoot feedback
for _ in 1 2 3; do press space Right; done
press space; shoot main
press space; shoot artifact
sleep .6; xdotool keydown Escape; sleep 2.6; xdotool keyup Escape; shoot pause
press F1
for trial in $(seq 36); do
  press Left
  if [ "$trial" = 20 ]; then shoot break; press space; fi
done
shoot thanks
press F3; shoot summary
press Return; sleep 1

# Somebody declines.
(cd "$work" && "$bin/equilux-session" run pocket --experiment artifact --participant DECLIN3 >/dev/null 2>&1) &
sleep 4
press BackSpace; shoot declined
press Return; sleep 1

# A window that becomes another size, then closed; the session goes on, until its log cannot be written.
resumed() { (cd "$work" && exec "$bin/equilux-session" run pocket --experiment artifact --participant RESUM3 >/dev/null 2>&1) & program=$!; sleep 4; }
resumed
press Return; choose 274 441; choose 274 567; press Return space space space space space space space space space Right
window=$(xdotool search --name Equilux | head -1)
xdotool windowsize "$window" 1000 800; shoot wrong-size
kill $program; sleep 1
resumed; shoot resumed
prlimit --pid $program --fsize=0; press space space Right; shoot stopped
press Return; sleep 1

# Material, as far as its first pair; then the session is ended.
"$bin/equilux-analyze" prune --kind person "$folder" >/dev/null
(cd "$work" && "$bin/equilux-session" run pocket --experiment material --participant ABC234 >/dev/null 2>&1) &
sleep 4
press Return; choose 274 441; choose 274 567; press Return space space space space space; shoot material-example
press space space space; shoot material
xdotool keydown Escape; sleep 2.6; xdotool keyup Escape; press F2; shoot ended
press Return; sleep 1

# What stops a session: a picture that was changed.
victim=$(find "$folder/pictures" -name '*C3-v0.png' | sort | head -1)
cp "$victim" "$work/kept.png" && printf x >>"$victim"
(cd "$work" && exec "$bin/equilux-session" run pocket >/dev/null 2>&1) &
refused=$!
sleep 3
press F1 F3 Return; shoot error
kill $refused
cp "$work/kept.png" "$victim"

# The workspace.
"$bin/equilux-session" simulate "$folder" --experiment artifact --subjects 12 --seed 1 >/dev/null
"$bin/equilux-analyze" prune --kind planted "$folder" >/dev/null
"$bin/equilux-session" simulate "$folder" --experiment material --subjects 14 --seed 1 >/dev/null
(cd "$work" && "$bin/equilux-session" browse pocket >/dev/null 2>&1) &
sleep 6
press k Right Up Up Up; shoot browse
press Return; shoot browse-picture
press d; shoot browse-difference
press BackSpace g; shoot browse-results
press BackSpace BackSpace; sleep 1

# Each screen with its name, in sheets.
sheet() {
  local name=$1 columns=$2; shift 2
  local files=()
  for screen in "$@"; do files+=(-label "$screen" "$work/$screen.png"); done
  montage "${files[@]}" -tile "${columns}x" -geometry 480x384+6+6 -font DejaVu-Sans -pointsize 15 -background white -strip -depth 8 \
    -define png:exclude-chunks=date,time "$out/$name.png"
}
sheet session-screens 3 consent questions instructions object example practice artifact-practice feedback main artifact \
  material-example material break thanks declined
sheet session-experimenter 3 start setup setup-card questions-missing pause wrong-size resumed stopped ended summary error \
  browse-difference
convert "$work/browse.png" -resize 70% -strip -depth 8 "$out/session-browse.png"
convert "$work/browse-results.png" -resize 70% -strip -depth 8 "$out/session-results.png"
