#!/usr/bin/env bash
# Makes the pictures of the gallery (libinsitu/doc/gallery.md) with the miniapps, and writes it between the page's marks.
#   bash examples/gallery/run.sh [--no-install] [--bin DIR] [picture ...]
# Without names: all of them, a few minutes. --bin: built programs, instead of building them. The pictures are
# libinsitu/doc/gallery_*.png, of 100 KiB at most each; the runs themselves stay in out/gallery.
set -euo pipefail
source "$(dirname "$0")/../../cmake/setup.sh"

# NAME | PROGRAM AND ARGUMENTS | SCENE | FRAME AND CYCLE | CAPTION
pictures=(
  "blast|sedov --cells 24 --cycles 130|sedov|blast_000130|Density as a volume, and the shock as a surface of pressure"
  "shells|sedov --cells 24 --cycles 130|sedov|shells_000130|The shock and two surfaces of density, a box cut out, with shadows and ambient occlusion"
  "decades|sedov --cells 24 --cycles 130|sedov|decades_000130|Density on the mirror planes by a logarithmic scale, with colours beyond its range, in the mesh's box with coordinates"
  "scattered|sedov --cells 24 --cycles 130|sedov|scattered_000130|The compressed gas as a cloud that scatters sunlight, path traced, with a surface within that takes and gives light"
  "levels|amr_blast --finest 4 --cycles 40 --checkers|amr_blast|levels_000040|Where an adaptive grid changes its level, cut open: from level 2 to 3 and from 3 to 4, with shadows"
  "checkers|amr_blast --finest 4 --cycles 40 --checkers|amr_blast|checkers_000040|The grid's cells in blue and white, those beside another level in red, cut open"
  "bubble|amr_blast --finest 4 --cycles 40 --checkers|amr_blast|bubble_000040|The blast on that grid: compressed gas as a volume, the bubble that it leaves as a surface"
)

no_install=0 bin=
chosen=()
while [ $# -gt 0 ]; do
  case $1 in
    --help|-h) sed -n '2,5s/^# //p' "$0"; exit 0 ;;
    --no-install) no_install=1 ;;
    --bin) bin=$(cd "$2" && pwd); shift ;;
    -*) echo "gallery: no option '$1'; see --help" >&2; exit 2 ;;
    *) chosen+=("$1") ;;
  esac
  shift
done
if [ -z "$bin" ]; then
  say "libinsitu: the gallery"
  ensure_packages "${packages[@]}"
  configure_and_build release -- sedov amr_blast
  bin=$project/build/release/bin
fi
cd "$project"

# A run makes the pictures of all its frames: each command once.
declare -A done
for entry in "${pictures[@]}"; do
  IFS='|' read -r name program scene frame _ <<< "$entry"
  [ ${#chosen[@]} -eq 0 ] || [[ " ${chosen[*]} " == *" $name "* ]] || continue
  out=out/gallery/$scene
  if [ -z "${done[$program $scene]:-}" ]; then
    rm -rf "$out"
    read -ra words <<< "$program"
    step "$program" "$out.log" "$bin/${words[0]}" "${words[@]:1}" --quiet \
      --scene "examples/gallery/$scene.yaml" --output "$out"
    done[$program $scene]=1
  fi
  picture=libinsitu/doc/gallery_$name.png
  bytes=$(stat -c %s "$out/$frame.png")
  [ "$bytes" -le 102400 ] || { echo "gallery: $out/$frame.png has $bytes bytes, more than 100 KiB" >&2; exit 1; }
  cp "$out/$frame.png" "$picture"
  say "  $picture: $bytes bytes"
done

table() {
  local i=0 row='' entry name scene caption
  echo "Made by \`bash examples/gallery/run.sh\` with the miniapps; what each shows is a few lines of a scene, in"
  echo "[examples/gallery](../../examples/gallery)."
  echo
  echo "<table>"
  for entry in "${pictures[@]}"; do
    IFS='|' read -r name _ scene _ caption <<< "$entry"
    [ $((i % 2)) -ne 0 ] || echo "<tr>"
    echo "<td width=\"50%\" valign=\"top\"><img src=\"gallery_$name.png\" alt=\"$caption\"><br>$caption (<a href=\"../../examples/gallery/$scene.yaml\">$scene</a>)</td>"
    i=$((i + 1))
    [ $((i % 2)) -ne 0 ] || echo "</tr>"
  done
  [ $((i % 2)) -eq 0 ] || echo "</tr>"
  echo "</table>"
}

begin='<!-- gallery -->' end='<!-- /gallery -->' page=libinsitu/doc/gallery.md
grep -qxF -- "$begin" "$page" && grep -qxF -- "$end" "$page" ||
  { echo "gallery: $page has no lines $begin and $end" >&2; exit 2; }
table > out/gallery/table.md
awk -v file=out/gallery/table.md -v begin="$begin" -v end="$end" '$0 == end { skip = 0 } !skip
  $0 == begin { print ""; while ((getline line < file) > 0) print line; print ""; skip = 1 }' "$page" > out/gallery/page.md
cp out/gallery/page.md "$page"
say "written: $page"
