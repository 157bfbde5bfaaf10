#!/usr/bin/env bash
# Installs what run.sh needs: Debian's Chromium with a font, and playwright-core, which drives it, in a folder that git ignores.
set -euo pipefail
cd "$(dirname "$0")"

if ! command -v chromium > /dev/null; then
  root=()
  if [ "$(id -u)" != 0 ]; then root=(sudo); fi
  "${root[@]}" apt-get update -qq
  "${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends chromium fonts-dejavu-core nodejs npm
fi
if [ ! -d node_modules/playwright-core ]; then
  npm install --no-audit --no-fund --no-package-lock --loglevel=error
fi
