/// The twin's control socket: a ROUTER that answers any REQ or DEALER.
#pragma once

#include <memory>
#include <stop_token>
#include <string>

#include "core/base/result.hpp"
#include "proto/rpc.hpp"

namespace ovws::twin {

class Control {
 public:
  /// Errc::unavailable if the port is in use, Errc::invalid if the endpoint is malformed.
  static Result<std::unique_ptr<Control>> bind(const std::string& endpoint);
  ~Control();
  Control(const Control&) = delete;
  Control& operator=(const Control&) = delete;

  const std::string& endpoint() const;  ///< as bound, with the real port in place of 0
  /// Body of the control thread. `dispatch` handles every request and answers before it returns.
  void work(const std::stop_token& stop, const RpcDispatch& dispatch);

 private:
  struct Impl;
  explicit Control(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws::twin
