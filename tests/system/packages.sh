#!/usr/bin/env bash
# packages.sh BUILD NINJA [--without PACKAGE]: whatever the build in BUILD read, linked or loads belongs to a package of
# `./atlas packages`, to one that these depend on, or to a system that has nothing else. So a package that this machine
# merely happens to have does not hide from the launcher's list. Exit code 1 names what is missing; 77: not a Debian.
#
#   headers       of the compiler's dependency files, as ninja keeps them
#   build files   entries to CMake packages that the configuration read
#   libraries     on link lines, and those that the executables load (ldd)
#   opened later  libraries that rendering loads (LD_DEBUG)
#   programs      that the launcher, the build, the tests or a run start
set -euo pipefail
build=$1 ninja=$2 without=${4:-}
root=$(cd "$(dirname "$0")/../.." && pwd)
[ -d /var/lib/dpkg/info ] || { echo "SKIPPED: no dpkg here, so nobody knows which package a file is of"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

system_headers() { "$ninja" -C "$build" -t deps | grep -oE '^ +/.*' | tr -d ' ' | grep -v "^$root/" | sort -u; }

build_files() { grep -oE '/usr/(lib|share|local)[^ |$:]*[Cc]onfig\.cmake' "$build/build.ninja" | sort -u; }

linked_libraries() {
  grep -E '^  LINK_LIBRARIES' "$build"/build.ninja | tr ' ' '\n' | sort -u >"$work/link"
  grep -E '^/.*\.(so|a)' "$work/link" || true
  sed -n 's/^-l//p' "$work/link" | while read -r name; do
    g++ -print-file-name="lib$name.so" | grep '^/' || g++ -print-file-name="lib$name.a" | grep '^/' || true
  done
}

loaded_libraries() { find "$build/bin" -type f -perm -1 -exec ldd {} + | grep -oE '/[^ ]+\.so[^ ]*' | sort -u; }

rendering_libraries() { # by EGL and by OSMesa, each in a process of its own
  LD_DEBUG=files LD_DEBUG_OUTPUT=$work/ld timeout 120 "$build/bin/test_sim" --gtest_filter='RenderContext*' >"$work/render" 2>&1 ||
    { tail -n 5 "$work/render" >&2; touch "$work/failed"; }
  cat "$work"/ld.* 2>/dev/null | grep -oE 'calling init: /[^ ]+' | cut -d' ' -f3 | sort -u
}

programs() {
  for name in bash awk comm flock grep sed cmake ctest ninja ccache c++ git clang-format ffmpeg python3; do
    (PATH=/usr/bin:/bin command -v $name) || { echo "no program $name" >&2; touch "$work/failed"; }
  done
}

# Packages that are installed and needed by the list: dependencies followed to the end, of alternatives the first installed.
closure() {
  "$root/atlas" packages | grep -vxF "$without" >"$work/list"
  dpkg-query -W -f='${db:Status-Status}\t${Package}\t${Essential}\t${Provides}\t${Pre-Depends}, ${Depends}\n' >"$work/installed"
  awk -F'\t' '
    function bare(s) { gsub(/[ \t]*\([^)]*\)|:any|:native|[ \t]/, "", s); return s }
    NR == FNR { todo[++n] = $1; next }
    $1 != "installed" { next }
    { needs[$2] = $5; if ($3 == "yes") todo[++n] = $2
      count = split($4, given, ","); for (i = 1; i <= count; ++i) { g = bare(given[i]); if (g) of[g] = of[g] " " $2 } }
    END {
      for (k = 1; k <= n; ++k) {
        p = todo[k]
        if (p in done) continue
        done[p] = 1
        if (!(p in needs)) { m = split(of[p], who, " "); for (i = 1; i <= m; ++i) todo[++n] = who[i]; continue }
        print p
        m = split(needs[p], groups, ",")
        for (i = 1; i <= m; ++i) {
          a = split(groups[i], alternatives, "|")
          for (j = 1; j <= a; ++j) { d = bare(alternatives[j]); if ((d in needs) || (d in of)) { todo[++n] = d; break } }
        }
      }
    }' "$work/list" "$work/installed" | sort -u
}

# Reads paths; prints "PACKAGE<tab>PATH" for each, PACKAGE ? where no package owns it. /lib is /usr/lib; a link that no
# package owns (an alternative) counts as what it leads to.
owners() {
  sort -u | while read -r path; do printf '%s\t%s\n' "$(realpath -sm "$path")" "$(realpath -m "$path")"; done >"$work/paths"
  awk -F'\t' '
    function merged(p) { return p ~ /^\/(lib|lib64|bin|sbin)\// ? "/usr" p : p }
    FILENAME == ARGV[1] { path[++n] = merged($1); real[n] = merged($2); wanted[path[n]] = wanted[real[n]] = 1; next }
    { p = merged($0); if (p in wanted) { f = FILENAME; sub(/.*\//, "", f); sub(/(:[a-z0-9]+)?\.list$/, "", f); of[p] = of[p] " " f } }
    END { for (i = 1; i <= n; ++i) { o = of[path[i]]; if (!o) o = of[real[i]]; print (o ? substr(o, 2) : "?") "\t" path[i] } }
  ' "$work/paths" /var/lib/dpkg/info/*.list
}

closure >"$work/closure"
for what in system_headers build_files linked_libraries loaded_libraries rendering_libraries programs; do
  $what >"$work/$what"
  count=$(wc -l <"$work/$what")
  echo "$what: $count"
  [ "$count" -gt 0 ] || touch "$work/failed"
  owners <"$work/$what" | awk -F'\t' -v what=$what '
    NR == FNR { allowed[$1] = 1; next }
    { m = split($1, who, " "); for (i = 1; i <= m; ++i) if (who[i] in allowed) next
      if (!seen[$1]++) print "MISSING from ./atlas packages: " ($1 == "?" ? "no package" : $1) " (" what ": " $2 ")" }
  ' "$work/closure" - >>"$work/missing"
done
cat "$work/missing"
[ ! -s "$work/missing" ] && [ ! -e "$work/failed" ]
