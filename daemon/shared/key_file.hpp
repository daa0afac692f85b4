/// CURVE key files, as `ovws keygen` writes them: a JSON object that only its owner may read.
#pragma once

#include <sys/types.h>
#include <string>

#include "core/base/result.hpp"
#include "drivers/zmq/curve.hpp"

namespace ovws {

struct KeyFile {
  KeyPair pair;
  std::string server_key;  ///< client's file only: the daemon's public key; may be empty
};

/// Loads a key file. Errors (field "path") say what to do; files with permissions for group or
/// others are refused. A file in $CREDENTIALS_DIRECTORY may be group-readable: systemd keeps other
/// users out of that folder, and its access lists show up as group bits.
Result<KeyFile> load_key_file(const std::string& path);
/// Path of the credential that systemd passed to this service by LoadCredential=; empty: none.
std::string credential_path(const std::string& name);
/// Writes a key file of mode 0600. Errors (field "path"): Errc::refused if it exists and `replace`
/// is false. A replaced file keeps its owner. Writing is atomic: readers find either the old keys,
/// or none, or the new keys, and an error leaves the old ones.
Result<void> write_key_file(const std::string& path, const KeyFile& keys, bool replace);

/// Reads a file. Refuses a file that has any of the mode bits `forbidden`, or that belongs neither
/// to root nor to this process's user. Errors: as load_key_file; `secrecy` is the error text for
/// forbidden mode bits.
Result<std::string> read_kept_file(const std::string& path, mode_t forbidden,
                                   const std::string& secrecy);

}  // namespace ovws
