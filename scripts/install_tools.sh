#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Install what the project needs from the system: Python's venv, GHDL, Verilator with a C++ compiler,
# Icarus, Chromium.
#
# Installs through apt, with sudo when not root, and says so first; milliseconds when nothing is missing.
# ghdl-llvm simulates the core about twice as fast as ghdl-mcode and works with cocotb and --synth as well.
set -euo pipefail

python=${PYTHON:-python3}
# A command may have arguments, as CXX="ccache g++".
ghdl=${GHDL:-ghdl}
ghdl=${ghdl%% *}
verilator=${VERILATOR:-verilator}
compiler=${CXX:-g++}

fail() {
  echo "setup: error: $1" >&2
  exit 2
}

packages=()
need() { # COMMAND PACKAGE: the package that brings a command
  command -v "$1" >/dev/null || packages+=("$2")
}

if ! command -v "$python" >/dev/null; then
  [[ $python == python3 ]] || fail "there is no $python; give one by PYTHON=..."
  packages+=(python3 python3-venv)
elif ! "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))'; then
  fail "$("$python" --version) is too old; install Python 3.11 or newer and give it by PYTHON=..."
elif ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
  packages+=("python3-venv")
fi
need "$ghdl" ghdl-llvm
# The engine verilator, and the tests of the netlist: 21 MB beside the 90 MB of GHDL with its LLVM and gcc.
need "${verilator%% *}" verilator
need "${compiler%% *}" g++
need iverilog iverilog
# The report's picture and its test.
need chromium chromium
need chromedriver chromium-driver

((${#packages[@]})) || exit 0

wanted="install ${packages[*]}"
command -v apt-get >/dev/null || fail "there is no apt-get; $wanted by hand"
sudo=()
if ((EUID != 0)); then
  command -v sudo >/dev/null || fail "not root and there is no sudo; $wanted by hand"
  sudo=(sudo)
fi

apt() {
  echo "setup: ${sudo[*]:+${sudo[*]} }apt-get $*"
  ${sudo[@]+"${sudo[@]}"} env DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0 "$@" >/dev/null
}

install() { apt install --no-install-recommends --yes "${packages[@]}"; }
update() { apt update || fail "apt-get update failed; $wanted by hand"; }

echo "setup: missing on this system: ${packages[*]}"
# A fresh machine knows no packages; one that was set up long ago knows versions that are gone.
apt-get -qq --simulate install "${packages[@]}" >/dev/null 2>&1 || update
install || { update && install; } || fail "apt-get failed; $wanted by hand"
command -v "$ghdl" >/dev/null || fail "there is still no $ghdl; $wanted by hand"
