/// Files of keys, as `ovws keygen` writes them: a small JSON object that nobody but its owner may
/// read.
#pragma once

#include <sys/types.h>
#include <string>

#include "core/base/result.hpp"
#include "drivers/zmq/curve.hpp"

namespace ovws {

struct KeyFile {
  KeyPair pair;
  std::string server_key;  ///< of a client's file: the daemon it is for; may be empty
};

/// Errors (field "path") say what to do; a file that group or others can read or write is refused.
/// A file in $CREDENTIALS_DIRECTORY may be read by the group: systemd sees to it that no other
/// user is in there, and an access list, where it uses one, shows as bits of the group.
Result<KeyFile> load_key_file(const std::string& path);
/// The file of that name which systemd's LoadCredential= gave this service; empty: it gave none.
std::string credential_path(const std::string& name);
/// Writes a new file of mode 0600. Errors (field "path"): Errc::refused if there is one and
/// `replace` is false. A file that is replaced keeps its owner. Whoever reads it while it is
/// replaced finds the old keys or the new ones; an error leaves the old ones.
Result<void> write_key_file(const std::string& path, const KeyFile& keys, bool replace);

/// The text of a file with none of the mode bits `forbidden`. Errors as of load_key_file; `secrecy`
/// says what the bits would mean ("others can change it").
Result<std::string> read_kept_file(const std::string& path, mode_t forbidden,
                                   const std::string& secrecy);

}  // namespace ovws
