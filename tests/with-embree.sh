#!/usr/bin/env bash
# Runs a command with what a build with the feature `embree` needs: Embree 4 and libclang.
#     tests/with-embree.sh cargo bench --features embree
# Where the machine has both, the command runs as it stands. Debian 13 and later install them (as root or with
# sudo). Any other Debian from 12 on unpacks Debian's packages below the target directory, once: Embree with
# the C library of Debian 13 that it needs, and libclang with whatever of its libraries the machine lacks.
# To use another Embree, set SOLIDTRACE_EMBREE_PREFIX to the folder of its libembree4.so.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() {
    printf '%s\n' "tests/with-embree.sh: $1" >&2
}

stop() {
    say "$1; or run \`cargo test --release\`, which leaves the comparisons with Embree out"
    exit 1
}

has_embree() {
    [[ -z ${SOLIDTRACE_EMBREE_PREFIX-} ]] || return 0
    local program status=0
    program=$(mktemp)
    cc -x c - -o "$program" -lembree4 <<<'int main(void) { return 0; }' 2>/dev/null || status=1
    rm -f "$program"
    return $status
}

# Looks where bindgen will.
has_libclang() {
    [[ -z ${LIBCLANG_PATH-} ]] || return 0
    local file
    for file in /usr/local/llvm*/lib*/libclang[.-]*so* /usr/{,local/}lib*/{,*/,*/*/}libclang[.-]*so*; do
        [[ $file == *-cpp.* || ! -e $file ]] || return 0
    done
    return 1
}

# From the distribution, where that needs no password.
install_packages() {
    local sudo=()
    if ((EUID != 0)); then
        sudo=(sudo -n)
        sudo -n true 2>/dev/null || return 1
    fi
    local apt=("${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq)
    say "installing libembree-dev and libclang-dev"
    "${apt[@]}" update </dev/null >&2 || true
    "${apt[@]}" install -y --no-install-recommends libembree-dev libclang-dev </dev/null >&2
}

# fetch FOLDER SUITE STATUS PACKAGE: what a machine with the dpkg status file STATUS lacks for PACKAGE, from
# Debian's SUITE into FOLDER. apt's lists are kept in the folder too, and the machine's own stay as they are.
fetch() {
    local folder=$1 suite=$2 status=$3 package=$4
    local keyring=/usr/share/keyrings/debian-archive-keyring.gpg
    local apt="$folder/apt" mirrors mirror deb
    mkdir -p "$apt/lists/partial" "$apt/archives/partial"
    local options=(
        -qq -oDebug::NoLocking=true
        -oDir::State="$apt" -oDir::State::Lists="$apt/lists" -oDir::State::status="$status" -oDir::Cache="$apt"
        -oDir::Etc::SourceList="$apt/sources.list" -oDir::Etc::SourceParts=/dev/null
        -oDir::Etc::Preferences=/dev/null -oDir::Etc::PreferencesParts=/dev/null
        -oAPT::Default-Release="$suite" -oAPT::Update::Error-Mode=any -oAPT::Sandbox::User=root
        -oAcquire::Languages=none -oAcquire::http::Timeout=30 -oAcquire::https::Timeout=30
    )
    # The machine's own mirrors; an archive that is not Debian's fails at the keyring and is passed over.
    mirrors=$(apt-get indextargets --no-release-info --format '$(SITE) $(RELEASE)' |
        awk -v suite="$VERSION_CODENAME" '$2 == suite || $2 ~ /^(old)*stable$/ { print $1 }' | sort -u) || true
    for mirror in $mirrors; do
        printf 'deb [signed-by=%s arch=%s target=Packages] %s %s main\n' \
            "$keyring" "$(dpkg --print-architecture)" "$mirror" "$suite" >"$apt/sources.list"
        if apt-get "${options[@]}" update </dev/null &&
            apt-get "${options[@]}" install -y --download-only --no-install-recommends "$package" </dev/null; then
            for deb in "$apt"/archives/*.deb; do
                dpkg -x "$deb" "$folder" || return 1
            done
            rm -r "$apt"
            return 0
        fi
    done
    return 1
}

# unpack NAME SUITE STATUS PACKAGE: fetches into $prefix/NAME, which gets its name last: it is whole or absent.
unpack() {
    local name=$1 package=$4
    [[ ! -d $prefix/$name ]] || return 0
    say "unpacking Debian's $package and what it needs into $prefix/$name, once"
    rm -rf "$prefix/$name.part"
    mkdir -p "$prefix/$name.part"
    if ! fetch "$prefix/$name.part" "${@:2}" >"$prefix/$name.log" 2>&1; then
        cat "$prefix/$name.log" >&2
        stop "$package cannot be fetched from Debian's archive: go online, once"
    fi
    mv "$prefix/$name.part" "$prefix/$name"
}

# Debian 13's Embree, with the C library that it was built for.
use_embree() {
    unpack embree trixie /dev/null libembree-dev
    SOLIDTRACE_EMBREE_PREFIX=$(dirname "$prefix"/embree/usr/lib/*/libembree4.so)
    export SOLIDTRACE_EMBREE_PREFIX
}

# libclang runs inside build scripts, so it is the machine's own release's. The C compiler's headers (stddef.h
# and the like) stand in for clang's.
use_libclang() {
    unpack libclang "$VERSION_CODENAME" /var/lib/dpkg/status libclang1
    local folder
    LIBCLANG_PATH=$(echo "$prefix"/libclang/usr/lib/*-linux-gnu)
    for folder in "$LIBCLANG_PATH" "$prefix"/libclang/lib/*-linux-gnu; do
        [[ ! -d $folder ]] || LD_LIBRARY_PATH=$folder${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
    done
    BINDGEN_EXTRA_CLANG_ARGS="${BINDGEN_EXTRA_CLANG_ARGS-} -idirafter $(cc -print-file-name=include)"
    export LD_LIBRARY_PATH LIBCLANG_PATH BINDGEN_EXTRA_CLANG_ARGS
}

if ! has_embree || ! has_libclang; then
    ID='' VERSION_ID=''
    [[ ! -r /etc/os-release ]] || source /etc/os-release
    # Testing and unstable have no number.
    [[ $ID == debian && ${VERSION_ID:=99} -ge 12 ]] ||
        stop "install Embree 4 (libembree4.so) and libclang with the system's package manager"
    mkdir -p "${CARGO_TARGET_DIR:-target}"
    prefix=$(cd "${CARGO_TARGET_DIR:-target}" && pwd)/embree-prefix
    if [[ $VERSION_ID -ge 13 && ! -d $prefix/embree ]]; then
        install_packages || true
    fi
    has_embree || use_embree
    has_libclang || use_libclang
fi

exec "$@"
