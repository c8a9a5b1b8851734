#!/bin/sh
# Does ./bootstrap wait for a package manager that is busy, and for no other failure? With an apt-get of a few lines.
set -u
[ "${1-}" != --list ] || exit 0 # the driver asks for names of tests, which it can do without
folder=$(mktemp -d) || exit 1
trap 'rm -rf "$folder"' EXIT
trap 'exit 130' HUP INT TERM
mkdir "$folder/bin" "$folder/kit"
cp "${srcdir:-.}/bootstrap" "$folder/kit"
PATH=$folder/bin:$PATH
count=0

stub() { # name: a program of that name that runs what stands on standard input
    { echo '#!/bin/sh' && cat; } >"$folder/bin/$1" && chmod +x "$folder/bin/$1"
}
stub dpkg-query </dev/null
stub sudo <<'END'
exec "$@"
END
stub sleep <<END
echo \$1 >>"$folder/slept"
END
stub apt-get <<END
echo "\$*" >>"$folder/asked"
case \$* in
*\$FAILING*) [ \$(wc -l <"$folder/asked") -gt \$TIMES ] || { echo "\$REASON" >&2; exit 100; } ;;
esac
END

verdict() { # name: the status of the last command, and what bootstrap said
    result=$?
    count=$((count + 1))
    [ $result = 0 ] || { sed 's/^/# /' "$folder/said" "$folder/asked"; printf 'not '; }
    echo "ok $count - $1"
}

# bootstrap COMMAND TIMES REASON: apt-get fails with the reason that many times. It ends after the packages: the kit's
# folder is empty otherwise.
bootstrap() {
    : >"$folder/asked"
    : >"$folder/slept"
    FAILING=$1 TIMES=$2 REASON=$3 "$folder/kit/bootstrap" >"$folder/said" 2>&1
    slept=$(wc -l <"$folder/slept")
}
says() { grep -qF -e "$1" "$folder/said"; }

held='E: Could not get lock /var/lib/apt/lists/lock. It is held by process 77 (apt-get)
E: Unable to lock directory /var/lib/apt/lists/'
bootstrap update 3 "$held"
[ "$slept" = 3 ] && [ "$(grep -c update "$folder/asked")" = 4 ] && grep -q install "$folder/asked"
verdict a_lock_of_the_lists_is_waited_for

[ "$(grep -c waiting "$folder/said")" = 1 ] && says 'at most 10 minutes: Could not get lock /var/lib/apt/lists/lock. It is held by process 77'
verdict that_is_said_once_with_the_longest_time_and_the_holder

bootstrap install 4 'E: Sperre /var/lib/dpkg/lock-frontend konnte nicht bekommen werden - open (11: Die Ressource ist nicht verfügbar)'
[ "$slept" = 3 ] && ! says 'could not install'
verdict a_lock_for_installing_is_waited_for_in_any_language

bootstrap install 1000 "$held"
[ "$slept" = 120 ] && says 'could not install' && says 'held by process 77'
verdict the_wait_ends_after_ten_minutes

bootstrap install 1000 'E: Could not open lock file /var/lib/dpkg/lock-frontend - open (13: Permission denied)'
[ "$slept" = 0 ] && says 'could not install' && says 'Permission denied'
verdict other_failures_are_told_at_once

stub apt-cache <<'END'
[ "$2" != firefox-esr ]
END
: >"$folder/asked"
FAILING=nothing "$folder/kit/bootstrap" --pdf --only-install >"$folder/said" 2>&1
says 'no package firefox-esr here; install Firefox yourself' && grep -q 'install.* chromium' "$folder/asked" &&
    ! grep -q firefox-esr "$folder/asked"
verdict a_browser_that_is_no_package_here_is_named_and_the_other_is_installed

# --- what configure is run again for: with a kit of a few lines ---

mkdir "$folder/kit/tools"
cat >"$folder/kit/configure" <<'END'
#!/bin/sh
echo "configured $*"
: >config.status
echo 'NEXT_COMMANDS = make start' >Makefile
END
printf '#!/bin/sh\n' >"$folder/kit/tools/features.sh"
chmod +x "$folder/kit/configure" "$folder/kit/tools/features.sh"
: >"$folder/kit/configure.ac"
: >"$folder/kit/Makefile.am"
: >"$folder/kit/features.am"
mkdir "$folder/kit/build-aux"
touch -d '1 minute' "$folder/kit/Makefile.in" 2>/dev/null || touch "$folder/kit/Makefile.in"
again() { "$folder/kit/bootstrap" --no-install "$@" >"$folder/said" 2>&1; }

again && says configured && again && says 'nothing has changed since the last run; next: make start'
verdict what_has_not_changed_is_not_configured_again

stub python3.13 <<'END'
echo Python 3.13.1
END
again && says configured && again && says 'nothing has changed'
verdict a_program_that_is_new_beside_dpkg_is_configured_for

stub python3.13 <<'END'
echo Python 3.13.2
END
again && says configured && again && says 'nothing has changed'
verdict another_version_of_it_is_too

again --student && says 'configured --quiet --enable-student' && again --student && says 'nothing has changed'
verdict configure_is_told_that_it_serves_a_student

mkdir "$folder/bare"
for tool in sh dirname env sed grep; do ln -s "$(command -v $tool)" "$folder/bare/$tool"; done
env PATH="$folder/bare" "$folder/kit/bootstrap" --no-install >"$folder/said" 2>&1
says 'what makes configure is missing; install autoconf automake pkg-config make'
verdict all_that_is_missing_is_said_at_once

printf '#!/bin/sh\necho 1000\n' >"$folder/bare/id"
chmod +x "$folder/bare/id"
ln -s "$folder/bin/dpkg-query" "$folder/bin/apt-get" "$folder/bare"
env PATH="$folder/bare" "$folder/kit/bootstrap" --student >"$folder/said" 2>&1
says 'ask an administrator for' && says 'apt-get install --no-install-recommends gcc make '
verdict the_administrators_line_installs_no_more_than_is_needed

echo "1..$count"
