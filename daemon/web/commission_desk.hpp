/// The commissioning that all browsers share.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "daemon/examine/commission/commissioning.hpp"
#include "daemon/shared/client.hpp"
#include "daemon/web/access.hpp"

namespace ovws::web {

constexpr std::string_view kCommissionPath = "/commission";
constexpr std::string_view kCommissionPicturePath = "/commission/picture?step=";

/// One commissioning with a connection and a thread of its own. It begins when a browser first asks
/// for it. Thread-safe; no function waits for the daemon.
class CommissionDesk {
 public:
  explicit CommissionDesk(cli::Common daemon) : daemon_(std::move(daemon)) {}

  /// The document `ovws.commission/1` with the key `right`, "control" or "look", of who asks.
  std::string report(Right right);
  /// Carries out {"action", "step", "offer"} and returns {"result": the document} or {"error":
  /// {"message", "data": {"field", "reason"}}}, as text. Errors: Refusal::malformed.
  tl::expected<std::string, Refusal> act(const std::string& body);
  /// The picture of a step as a PNG file; empty: it has none.
  std::string picture(std::string_view step);

  /// Cancels a running step, which restores what it has changed, and waits for its end.
  void end();

 private:
  std::shared_ptr<commission::Commissioning> commissioning();

  const cli::Common daemon_;
  std::mutex mutex_;  ///< guards all below
  bool ended_ = false;
  std::shared_ptr<commission::Commissioning> commissioning_;
};

}  // namespace ovws::web
