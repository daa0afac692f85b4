/// HTTP server: serves the page, streams the board to each browser at that browser's own pace, and
/// forwards allowed commands.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "core/base/result.hpp"
#include "daemon/shared/client.hpp"
#include "daemon/web/access.hpp"
#include "daemon/web/board.hpp"
#include "daemon/web/commission_desk.hpp"
#include "daemon/web/hologram_image.hpp"
#include "daemon/web/picture.hpp"
#include "daemon/web/recordings.hpp"

namespace ovws::web {

/// Limit of concurrent connections. A further connection replaces the oldest connection without a
/// valid token; if all have a token, the further connection is closed.
constexpr std::size_t kMaxConnections = 64;
constexpr int kMaxBrowsers = 16;  ///< concurrent streams

/// Objects that the server uses. Each of them must outlive the server.
struct ServerParts {
  const cli::Common& common;
  const Access& access;
  RefusalLog& refusals;
  const Board& board;
  std::function<HologramImagePtr()> hologram;
  std::function<CameraImagePtr()> image;  ///< the camera's newest image, or null
  std::function<void()>
      commanded;  ///< called after a command that may change the bench; in any thread
  CommissionDesk& commission;
  std::atomic<int>& browsers;   ///< number of open streams
  Tickets& tickets;             ///< used by the server's thread only
  std::atomic<int>& downloads;  ///< number of recordings that are being sent
};

class Server {
 public:
  /// Binds and listens. Errors (field "--listen"): Errc::invalid if the address is not numeric,
  /// Errc::unavailable if it is in use.
  static Result<std::unique_ptr<Server>> listen(const std::string& address, unsigned short port,
                                                ServerParts parts);
  ~Server();  ///< waits for running commands
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// Serves until SIGINT or SIGTERM, then drops queued commands. Runs in the calling thread; only
  /// calls to the daemon block in other threads.
  void run();

 private:
  struct Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws::web
