#!/usr/bin/env bash
# Installs what run.sh needs: Debian's Chromium with a font, Node unless there is one, and playwright-core, which drives them, in a
# folder that git ignores.
set -euo pipefail
cd "$(dirname "$0")"

if ! command -v chromium > /dev/null; then
  root=()
  if [ "$(id -u)" != 0 ]; then root=(sudo); fi
  packages=(chromium fonts-dejavu-core)
  # Node from elsewhere brings an npm of its own, beside which Debian's cannot be installed.
  command -v npm > /dev/null || packages+=(nodejs npm)
  "${root[@]}" apt-get update -qq
  "${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${packages[@]}"
fi
if [ ! -d node_modules/playwright-core ]; then
  npm install --no-audit --no-fund --no-package-lock --loglevel=error
fi
