# Shared by ./run and ./check: installing Debian packages and building a preset. Sourced, not run.
# shellcheck shell=bash

# What every build and the programs need.
packages_build=(cmake ninja-build g++ pkg-config
  libembree-dev libtbb-dev libopenexr-dev libpng-dev libopenimageio-dev libassimp-dev libsqlite3-dev libssl-dev libboost-dev
  libfmt-dev libcli11-dev nlohmann-json3-dev libvalijson-dev
  gnuplot-nox libglfw3-dev libimgui-dev libgl-dev libx11-dev libgl1-mesa-dri fonts-dejavu-core)
# What the tests need beside it.
packages_test=(libgtest-dev libgmock-dev libxtst-dev xvfb xserver-xorg-core xserver-xorg-video-dummy x11-xserver-utils
  clang-format git munge openimageio-tools pfstmo python3 slurm-wlm r-base-core r-cran-lme4
  r-cran-psyphy chromium poppler-utils)

say() { printf '\n== %s\n' "$*"; }

# as_root COMMAND...: as it is for root, by sudo for others.
as_root() {
  if [ "$(id -u)" = 0 ]; then
    env DEBIAN_FRONTEND=noninteractive "$@"
  elif command -v sudo >/dev/null; then
    sudo env DEBIAN_FRONTEND=noninteractive "$@"
  else
    echo "$0: packages are missing and there is neither root nor sudo to install them: $*" >&2
    return 1
  fi
}

missing_packages() {
  local package
  for package in "$@"; do
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || echo "$package"
  done
}

# apt COMMAND...: with its own progress on a terminal, else quiet with a log that is shown if it fails. Several package runs may
# meet: wait for the lock.
apt() {
  local log
  if [ -t 1 ]; then
    as_root apt-get -o DPkg::Lock::Timeout=600 "$@"
    return
  fi
  log=$(mktemp)
  if as_root apt-get -o DPkg::Lock::Timeout=600 "$@" >"$log" 2>&1; then
    rm -f "$log"
  else
    tail -n 30 "$log" >&2
    echo "$0: apt-get $1 failed; the whole log is in $log" >&2
    return 1
  fi
}

# install_packages PACKAGE...: installs what is missing, asking the package system only then.
install_packages() {
  local missing
  mapfile -t missing < <(missing_packages "$@")
  [ "${#missing[@]}" -gt 0 ] || { echo "all ${#} packages are installed"; return; }
  echo "installing ${#missing[@]} packages and what they need, a minute or two: ${missing[*]}"
  apt update && apt install -y --no-install-recommends "${missing[@]}"
}

# show_build: ninja's lines "@DONE ALL SECONDS WHAT" with an estimate of the seconds left; on a terminal in one line.
show_build() {
  local line end=$'\n'
  [ ! -t 1 ] || end=$'\r'
  while IFS= read -r line; do
    if [[ $line =~ ^@([0-9]+)\ ([0-9]+)\ ([0-9]+)[0-9.]*\ (.*)$ ]]; then
      local finished=${BASH_REMATCH[1]} all=${BASH_REMATCH[2]} seconds=${BASH_REMATCH[3]} what=${BASH_REMATCH[4]}
      [ "$end" = $'\n' ] || printf '\e[K'
      printf '[%d/%d] %d s left: %.80s%s' "$finished" "$all" $((seconds * (all - finished) / finished)) "${what##*/}" "$end"
    else
      printf '%s\n' "$line"
    fi
  done
  [ "$end" = $'\n' ] || echo
}

# build_preset PRESET [CMAKE-OPTION...]
build_preset() {
  local preset=$1 log
  shift
  log=build/$preset-configure.log
  mkdir -p build
  cmake --preset "$preset" "$@" >"$log" 2>&1 || { cat "$log" >&2; return 1; }
  NINJA_STATUS='@%f %t %e ' cmake --build --preset "$preset" 2>&1 | show_build
}
