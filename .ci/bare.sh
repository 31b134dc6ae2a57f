# For the scripts in this folder: bare Debian systems in build-bare/, from the mirror of this machine. Needs root.
# shellcheck shell=bash disable=SC2034
releases=(bookworm trixie)  # Debian 12 and 13

# bare RELEASE NAME: makes a bare system with the files of this tree in /assur.
bare() {
  local mirror root=$PWD/build-bare/$2
  mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' \
    "Codename: $(. /etc/os-release && echo "$VERSION_CODENAME")" | sed 1q)
  rm -rf --one-file-system "$root"
  mkdir -p "$root"
  debootstrap --variant=minbase "$1" "$root" "$mirror"
  echo '127.0.0.1 localhost' >"$root/etc/hosts"  # as the installer does; chromedriver's clients ask for it
  mkdir "$root/assur"
  git ls-files -z | tar --create --null --files-from=- | tar --extract --directory "$root/assur"
}

# inside NAME COMMAND...: runs a command in this system, in /assur. What it mounts ends with it.
inside() {
  unshare --mount bash -euc 'cd "$1"
    mount -t proc proc proc
    mount --rbind /sys sys
    mount --rbind /dev dev
    exec env --ignore-environment HOME=/root LANG=C.UTF-8 PATH=/usr/sbin:/usr/bin:/sbin:/bin \
      DEBIAN_FRONTEND=noninteractive chroot . sh -ec "cd /assur; exec \"\$@\"" - "${@:2}"' - "build-bare/$1" "${@:2}"
}
