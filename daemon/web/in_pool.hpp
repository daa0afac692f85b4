/// Blocking work for a connection, in a thread of a pool.
#pragma once

#include <poll.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <optional>

#include "daemon/web/http.hpp"

namespace ovws::web {

/// Whether the browser closed its side of the connection (POLLRDHUP), even with data left unread.
inline bool has_disconnected(tcp::socket& browser) {
  pollfd look{browser.native_handle(), POLLRDHUP, 0};
  return ::poll(&look, 1, 0) != 0;
}

/// Runs `work`, first come, first served. None if the browser disconnects first; work that has not
/// begun is then dropped, and work that has may outlive the connection.
template <class T>
Task<std::optional<T>> in_pool(net::thread_pool& pool, tcp::socket& browser,
                               const std::function<T()>& work) {
  constexpr std::chrono::milliseconds kPollInterval{2};
  const auto left = std::make_shared<std::atomic<bool>>(false);
  const auto call = std::make_shared<std::packaged_task<std::optional<T>()>>(
      [work, left] { return *left ? std::nullopt : std::optional<T>(work()); });
  std::future<std::optional<T>> reply = call->get_future();
  net::post(pool, [call] { (*call)(); });
  net::steady_timer timer(co_await net::this_coro::executor);
  while (reply.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
    if (has_disconnected(browser)) {
      *left = true;
      co_return std::nullopt;
    }
    timer.expires_after(kPollInterval);
    co_await timer.async_wait(net::use_awaitable);
  }
  co_return reply.get();
}

}  // namespace ovws::web
