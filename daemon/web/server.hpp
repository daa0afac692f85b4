/// The HTTP side: gives the page, streams the board to each browser at the browser's own pace, and
/// passes on the commands that it may.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "core/base/result.hpp"
#include "daemon/shared/client.hpp"
#include "daemon/web/access.hpp"
#include "daemon/web/board.hpp"
#include "daemon/web/hologram_picture.hpp"

namespace ovws::web {

/// At a time. One more takes the place of the oldest that has shown no token; if all have, it is
/// closed.
constexpr std::size_t kMostConnections = 64;
constexpr int kMostBrowsers = 16;  ///< streams at a time

/// What the server stands on; all of it outlives the server.
struct ServerParts {
  const cli::Common& common;
  const Access& access;
  RefusalLog& refusals;
  const Board& board;
  std::function<HologramPicturePtr()> hologram;
  std::atomic<int>& browsers;  ///< how many streams are open
};

class Server {
 public:
  /// Binds at once. Errors (field "--listen"): Errc::invalid for what is no address in numbers,
  /// Errc::unavailable if it is taken.
  static Result<std::unique_ptr<Server>> listen(const std::string& address, unsigned short port,
                                                ServerParts parts);
  ~Server();  ///< waits for the commands that are under way
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// Serves until SIGINT or SIGTERM, then drops what waits for its turn. All happens in the calling
  /// thread, but for the waiting for the daemon's answers to commands.
  void run();

 private:
  struct Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws::web
