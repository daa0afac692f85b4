#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "drivers/zmq/client.hpp"
#include "drivers/zmq/control_server.hpp"
#include "drivers/zmq/gate.hpp"
#include "drivers/zmq/publisher.hpp"
#include "tests/contract/zmq/endpoints.hpp"

namespace ovws {
namespace {

using namespace std::chrono_literals;

KeyPair new_pair() {
  return make_key_pair().value();
}

/// A gate with a publisher and a server behind it. The server answers with the client's key.
class Guarded {
 public:
  explicit Guarded(const std::string& name)
      : control(test::ipc_endpoint(name + "-control")), stream(test::ipc_endpoint(name)) {
    GateCalls calls;
    calls.knows = [this](const std::string& key) {
      const std::lock_guard lock(mutex_);
      return known_.contains(key);
    };
    calls.rejected = [this](const std::string&) { ++rejected; };
    calls.rebound = [this](const std::string& endpoint, const Result<void>& bound) {
      EXPECT_EQ(endpoint, stream);
      rebound.push_back(bound ? "" : bound.error().reason);
    };
    gate_ = Gate::make(daemon.secret_key, std::move(calls)).value();
    publisher_ = std::make_unique<Publisher>(Publisher::bind(stream, 10, gate_.get()).value());
    server_ = ControlServer::bind(
                  control, {1000, 0, "too large", "too many"},
                  [](const ControlRequest& request, const SendReply& reply) {
                    reply(request.client_key, nullptr);
                  },
                  gate_.get())
                  .value();
    thread_ = std::thread([this] {
      while (!stop_) server_->do_work();
    });
  }
  ~Guarded() {
    stop_ = true;
    thread_.join();
  }
  KeyPair let_in() {
    const KeyPair pair = new_pair();
    const std::lock_guard lock(mutex_);
    known_.insert(pair.public_key);
    return pair;
  }
  void forget(const KeyPair& pair) {
    const std::lock_guard lock(mutex_);
    known_.erase(pair.public_key);
  }
  Gate& gate() { return *gate_; }
  /// Publishes until `subscriber` receives one of these messages; false on time-out.
  bool reaches(Subscriber& subscriber, std::chrono::milliseconds patience = 60s) {
    const std::string ours = std::to_string(++calls_);
    const auto end = std::chrono::steady_clock::now() + patience;
    while (std::chrono::steady_clock::now() < end) {
      publisher_->send("t", ours);
      while (const auto message = subscriber.receive(10ms)) {
        if (message->json == ours) return true;
      }
    }
    return false;
  }

  std::string control, stream;
  KeyPair daemon = new_pair();
  std::atomic<int> rejected{0};
  std::vector<std::string> rebound;  ///< this thread: error of each rebound call; empty: bound

 private:
  int calls_ = 0;
  std::mutex mutex_;
  std::set<std::string> known_;
  std::unique_ptr<Gate> gate_;
  std::unique_ptr<Publisher> publisher_;
  std::unique_ptr<ControlServer> server_;
  std::thread thread_;
  std::atomic<bool> stop_{false};
};

Result<std::string> ask(const Guarded& guarded, const std::optional<ClientKeys>& keys) {
  auto client = ControlClient::connect(guarded.control, keys);
  if (!client) return fail(client.error());
  return client->request("x", 5000ms);
}

TEST(Gate, SaysWhoAsks) {
  Guarded guarded("who");
  const KeyPair one = guarded.let_in(), other = guarded.let_in();
  EXPECT_EQ(ask(guarded, ClientKeys{one, guarded.daemon.public_key}), one.public_key);
  EXPECT_EQ(ask(guarded, ClientKeys{other, guarded.daemon.public_key}), other.public_key);
  EXPECT_EQ(guarded.rejected, 0);
}

TEST(Gate, ReportsToAClientWhyItIsRejected) {
  Guarded guarded("why");
  const KeyPair good = guarded.let_in();
  const auto reason = [&guarded](const std::optional<ClientKeys>& keys) {
    const int before = guarded.rejected;
    const auto answer = ask(guarded, keys);
    EXPECT_FALSE(answer);
    for (int k = 0; k < 1000 && guarded.rejected == before; ++k) std::this_thread::sleep_for(10ms);
    EXPECT_GT(guarded.rejected, before);
    return answer ? std::string() : answer.error().reason;
  };
  EXPECT_NE(reason(std::nullopt).find("--key"), std::string::npos);
  EXPECT_NE(reason(ClientKeys{new_pair(), guarded.daemon.public_key}).find("security.clients"),
            std::string::npos);
  EXPECT_NE(reason(ClientKeys{good, new_pair().public_key}).find("server key"), std::string::npos);
}

TEST(Gate, EndsOnlyTheStreamsOfClientsThatWereRemoved) {
  Guarded guarded("streams");
  const KeyPair stays = guarded.let_in(), goes = guarded.let_in();
  const std::string& server_key = guarded.daemon.public_key;
  auto first = Subscriber::connect(guarded.stream, {}, 100, ClientKeys{stays, server_key}).value();
  auto second = Subscriber::connect(guarded.stream, {}, 100, ClientKeys{goes, server_key}).value();
  EXPECT_TRUE(guarded.reaches(first));
  EXPECT_TRUE(guarded.reaches(second));
  guarded.forget(goes);
  guarded.gate().end_streams();
  EXPECT_TRUE(guarded.reaches(first));
  EXPECT_FALSE(guarded.reaches(second, 1s));
}

TEST(Gate, ReportsAStreamThatCannotBeReboundAndItsRecovery) {
  const std::string folder = test::ipc_endpoint("folder").substr(std::strlen("ipc://"));
  std::filesystem::create_directory(folder);
  Guarded guarded("folder/stream");
  const KeyPair pair = guarded.let_in();
  auto subscriber =
      Subscriber::connect(guarded.stream, {}, 100, ClientKeys{pair, guarded.daemon.public_key})
          .value();
  EXPECT_TRUE(guarded.reaches(subscriber));
  guarded.gate().end_streams();
  EXPECT_TRUE(guarded.reaches(subscriber));
  EXPECT_EQ(guarded.rebound, std::vector<std::string>{}) << "one that succeeds is no news";
  std::filesystem::rename(folder, folder + "-away");
  guarded.gate().end_streams();
  for (int k = 0; k < 2000 && guarded.rebound.empty(); ++k) guarded.reaches(subscriber, 10ms);
  ASSERT_EQ(guarded.rebound.size(), 1U);
  EXPECT_NE(guarded.rebound[0].find(guarded.stream), std::string::npos) << guarded.rebound[0];
  EXPECT_FALSE(guarded.reaches(subscriber, 1s));
  EXPECT_EQ(guarded.rebound.size(), 1U) << "reported once";
  std::filesystem::rename(folder + "-away", folder);
  EXPECT_TRUE(guarded.reaches(subscriber));
  ASSERT_EQ(guarded.rebound.size(), 2U);
  EXPECT_EQ(guarded.rebound[1], "");
}

TEST(Gate, RefusesMalformedKeys) {
  EXPECT_EQ(Gate::make("short", {}).error().field, "security.secret_key");
  const KeyPair pair = new_pair();
  EXPECT_EQ(public_key_of(pair.secret_key), pair.public_key);
  EXPECT_FALSE(is_curve_key(pair.public_key + "0"));
  EXPECT_FALSE(is_curve_key(std::string(40, '~')));
  const auto mixed =
      ControlClient::connect(test::ipc_endpoint("none"),
                             ClientKeys{{pair.public_key, new_pair().secret_key}, pair.public_key});
  EXPECT_EQ(mixed.error().field, "key");
}

}  // namespace
}  // namespace ovws
