#include "daemon/web/callers.hpp"

#include <poll.h>

#include <chrono>

namespace ovws::web {
namespace {

constexpr std::chrono::milliseconds kPollInterval{10};  ///< of a waiting call

/// Scope guard that keeps a number in a set.
class Entry {
 public:
  Entry(std::set<std::uint64_t>& numbers, std::uint64_t number)
      : numbers_(numbers), number_(number) {
    numbers_.insert(number_);
  }
  ~Entry() { numbers_.erase(number_); }
  Entry(const Entry&) = delete;
  Entry& operator=(const Entry&) = delete;

 private:
  std::set<std::uint64_t>& numbers_;
  std::uint64_t number_;
};

/// Whether the browser closed its side of the connection (POLLRDHUP), even with data left unread.
bool has_disconnected(tcp::socket& browser) {
  pollfd look{browser.native_handle(), POLLRDHUP, 0};
  return ::poll(&look, 1, 0) != 0;
}

}  // namespace

Task<bool> Callers::turn(tcp::socket& browser, std::uint64_t number) {
  const Entry waiting(waiting_, number);
  net::steady_timer timer(co_await net::this_coro::executor);
  while (!has_disconnected(browser)) {
    if (*waiting_.begin() == number && under_way_.size() < kCalls) co_return true;
    timer.expires_after(kPollInterval);
    co_await timer.async_wait(net::use_awaitable);
  }
  co_return false;
}

Task<std::optional<std::string>> Callers::carry_out(tcp::socket& browser, const Call& call) {
  const std::uint64_t number = next_++;
  if (!co_await turn(browser, number)) co_return std::nullopt;
  const Entry under_way(under_way_, number);
  std::string reply = co_await net::co_spawn(
      threads_.get_executor(), [&]() -> Task<std::string> { co_return call(); },
      net::use_awaitable);
  co_return reply;
}

}  // namespace ovws::web
