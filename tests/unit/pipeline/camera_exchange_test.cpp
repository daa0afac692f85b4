/// A camera is attached and detached only when its buffers are returned; the wait has a time-out.
#include "core/pipeline/camera_exchange.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/support/time.hpp"
#include "tests/unit/pipeline/scripted_camera.hpp"

namespace ovws::test {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kPatience = std::chrono::hours(1);

/// A thread that serves with a number of lent buffers, as an acquisition agent does. While a
/// request waits for them, its time passes at once.
class Server {
 public:
  Server(CameraExchange& exchange, int lent)
      : lent_(lent), thread_([this, &exchange] {
          while (!stop_) {
            if (exchange.can_serve(lent_)) {
              ++changes_;
              exchange.serve();
            } else if (exchange.camera() != nullptr && !exchange.streaming()) {
              skip(kPatience);
            }
            std::this_thread::sleep_for(std::chrono::microseconds(100));
          }
        }) {}
  ~Server() {
    stop_ = true;
    thread_.join();
  }
  void set_lent(int lent) { lent_ = lent; }
  int changes() const { return changes_; }

 private:
  std::atomic<int> lent_;
  std::atomic<bool> stop_{false};
  std::atomic<int> changes_{0};
  std::thread thread_;
};

TEST(CameraExchange, AttachAndDetachReturnWhenTheAgentHasFollowed) {
  CameraExchange exchange(kPatience);
  ScriptedCamera camera(2, 16);
  {
    Server server(exchange, 0);
    ASSERT_TRUE(exchange.attach(camera));
    EXPECT_EQ(server.changes(), 1);
  }
  EXPECT_EQ(exchange.camera(), &camera);
  EXPECT_TRUE(exchange.streaming());
  {
    Server server(exchange, 0);
    ASSERT_TRUE(exchange.detach());
  }
  EXPECT_EQ(exchange.camera(), nullptr);
  EXPECT_FALSE(exchange.streaming());
}

TEST(CameraExchange, WithNobodyTurningTheAgentItGivesUpAndSaysSo) {
  CameraExchange exchange(milliseconds(20));
  ScriptedCamera camera(2, 16);
  const Result<void> answer = exchange.attach(camera);
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().code, Errc::unavailable);
  EXPECT_NE(answer.error().reason.find("did not run for 20 ms"), std::string::npos);
}

TEST(CameraExchange, WithABufferStillLentItGivesUpAndSaysHowMany) {
  CameraExchange exchange(kPatience);
  ScriptedCamera camera(2, 16);
  {
    Server server(exchange, 0);
    ASSERT_TRUE(exchange.attach(camera));
    server.set_lent(3);
    const Result<void> answer = exchange.detach();
    ASSERT_FALSE(answer);
    EXPECT_NE(answer.error().reason.find("3 camera buffers"), std::string::npos);
  }
  Server server(exchange, 0);
  EXPECT_TRUE(exchange.detach());
}

/// For the thread sanitizer: relaxed operations order the steps without synchronising them, so only
/// the exchange itself can publish the second camera.
TEST(CameraExchange, ACameraTakenEarlyIsSeenAsItWasHandedOver) {
  CameraExchange exchange(milliseconds(1));
  ScriptedCamera first(2, 16);
  ASSERT_FALSE(exchange.attach(first));
  std::atomic<int> step{0};
  const auto wait_for = [&step](int wanted) {
    while (step.load(std::memory_order_relaxed) < wanted) std::this_thread::yield();
  };
  std::thread acquisition([&] {
    EXPECT_TRUE(exchange.can_serve(0));  // sees the request for the first
    step.store(1, std::memory_order_relaxed);
    wait_for(2);
    exchange.serve();
    EXPECT_EQ(exchange.camera()->buffer_count(), 3);
    step.store(3, std::memory_order_relaxed);
  });
  wait_for(1);
  ScriptedCamera second(3, 16);
  EXPECT_FALSE(exchange.attach(second));  // the request remains
  step.store(2, std::memory_order_relaxed);
  wait_for(3);
  acquisition.join();
}

TEST(CameraExchange, WhileARequestWaitsNoFrameIsTaken) {
  CameraExchange exchange(milliseconds(1));
  ScriptedCamera camera(2, 16);
  ASSERT_FALSE(exchange.attach(camera));  // the request remains and is served on the next iteration
  EXPECT_TRUE(exchange.can_serve(0));
  exchange.serve();
  EXPECT_TRUE(exchange.streaming());
  ASSERT_FALSE(exchange.detach());
  EXPECT_FALSE(exchange.can_serve(1));
  EXPECT_FALSE(exchange.streaming());
  EXPECT_EQ(exchange.camera(), &camera);  // to give the buffer back to
  EXPECT_TRUE(exchange.can_serve(0));
  exchange.serve();
  EXPECT_EQ(exchange.camera(), nullptr);
}

}  // namespace
}  // namespace ovws::test
