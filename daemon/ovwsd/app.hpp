/// The composition root: creates every part of the daemon, connects the parts, and runs them until
/// a stop is requested.
#pragma once

#include <atomic>

#include "daemon/ovwsd/settings/saved_config.hpp"

namespace ovws {

/// The whole daemon; call it in the main thread. Creates all parts, opens the sockets, starts the
/// threads, and shows holograms until `stop` is set. Then it stops all threads in order. When
/// `reload` is set, it clears it, and reloads the configuration file. A signal handler may set
/// both, `reload` also during the start. An absent camera or display is no error: the daemon waits.
/// Returns false after it has logged an error: the configuration makes no usable sensor; a port or
/// the state folder is in use; a privilege is missing under `"realtime": "enforce"`; a thread
/// failed without which the daemon cannot continue; data could not be written at the stop.
[[nodiscard]] bool run_daemon(const LoadedConfig& loaded, const std::atomic<bool>& stop,
                              std::atomic<bool>& reload);

}  // namespace ovws
