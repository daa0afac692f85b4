#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <deque>
#include <mutex>
#include <thread>

#include "drivers/zmq/client.hpp"
#include "drivers/zmq/control_server.hpp"
#include "proto/rpc.hpp"
#include "tests/contract/zmq/endpoints.hpp"
#include "tests/contract/zmq/raw_client.hpp"

namespace ovws {
namespace {

using namespace std::chrono_literals;
using test::RawClient;

const ControlLimits kLimits{kMaxRequestBytes, 3 << 20, "too large", "too many"};

/// Handler of requests and replies without binary frames.
using TextHandler = std::function<void(std::string_view request, const std::string& client_key,
                                       std::function<void(std::string)> reply)>;
ControlHandler without_binary(TextHandler handle) {
  return [handle = std::move(handle)](const ControlRequest& request, SendReply reply) {
    handle(request.bytes, request.client_key,
           [reply = std::move(reply)](std::string bytes) { reply(std::move(bytes), nullptr); });
  };
}

/// A server with its thread. The default handler answers "re:" + request.
class Served {
 public:
  explicit Served(const std::string& endpoint, ControlHandler handler = echo()) {
    auto bound = ControlServer::bind(endpoint, kLimits, std::move(handler));
    EXPECT_TRUE(bound) << bound.error().reason;
    server_ = std::move(*bound);
    thread_ = std::thread([this] {
      while (!stop_) server_->do_work();
    });
  }
  Served(const std::string& endpoint, TextHandler handler)
      : Served(endpoint, without_binary(std::move(handler))) {}
  ~Served() { stop(); }
  void stop() {
    if (!thread_.joinable()) return;
    stop_ = true;
    thread_.join();
    server_.reset();
  }

  static ControlHandler echo() {
    return [](const ControlRequest& request, const SendReply& reply) {
      reply("re:" + request.bytes,
            request.binary.empty() ? nullptr
                                   : std::make_shared<const std::string>("re:" + request.binary));
    };
  }

 private:
  std::unique_ptr<ControlServer> server_;
  std::thread thread_;
  std::atomic<bool> stop_{false};
};

using Frames = std::vector<std::string>;

/// Bound to `bound`, asked at `reached`.
void expect_answer(const std::string& bound, const std::string& reached) {
  const Served served(bound);
  auto client = ControlClient::connect(reached);
  ASSERT_TRUE(client) << client.error().reason;
  const auto reply = client->request("hello", 5000ms);
  ASSERT_TRUE(reply) << bound << " at " << reached << ": " << reply.error().reason;
  EXPECT_EQ(*reply, "re:hello");
}

TEST(ControlServer, AnswersOverIpv6) {
  const std::string loopback = test::ipv6_endpoint();
  if (loopback.empty()) GTEST_SKIP() << "this machine has no IPv6";
  expect_answer(loopback, loopback);
  const std::string reached = test::ipv6_endpoint();
  const std::string port = reached.substr(reached.rfind(':'));
  expect_answer("tcp://[::]" + port, reached);
  expect_answer("tcp://127.0.0.1" + port, "tcp://localhost" + port);  // a name means IPv4
}

TEST(ControlServer, AnswersReqAndDealerWithAndWithoutDelimiter) {
  const auto endpoint = test::ipc_endpoint("kinds");
  const Served served(endpoint);
  RawClient req(ZMQ_REQ, endpoint), bare(ZMQ_DEALER, endpoint), delimited(ZMQ_DEALER, endpoint);
  req.send({"a"});
  bare.send({"b"});
  delimited.send({"", "c"});
  EXPECT_EQ(req.receive(), Frames{"re:a"});
  EXPECT_EQ(bare.receive(), Frames{"re:b"});
  EXPECT_EQ(delimited.receive(), (Frames{"", "re:c"}));
}

TEST(ControlServer, EchoesTheEnvelopeOfAProxy) {
  const auto endpoint = test::ipc_endpoint("proxy");
  const Served served(endpoint);
  RawClient dealer(ZMQ_DEALER, endpoint);
  dealer.send({"hop", "", "x"});
  EXPECT_EQ(dealer.receive(), (Frames{"hop", "", "re:x"}));
}

TEST(ControlServer, PassesOneBinaryFrameEachWay) {
  const auto endpoint = test::ipc_endpoint("binary");
  const Served served(endpoint);
  const std::string picture(kLimits.max_binary_bytes, '\xff');
  RawClient req(ZMQ_REQ, endpoint), bare(ZMQ_DEALER, endpoint), delimited(ZMQ_DEALER, endpoint);
  req.send({"a", picture});
  bare.send({"b", picture});
  delimited.send({"", "c", ""});
  EXPECT_EQ(req.receive(), (Frames{"re:a", "re:" + picture}));
  EXPECT_EQ(bare.receive(), (Frames{"re:b", "re:" + picture}));
  EXPECT_EQ(delimited.receive(), (Frames{"", "re:c"}));  // an empty frame is none
  bare.send({"d", picture + "x"});
  EXPECT_TRUE(bare.receive(300).empty());  // libzmq closes the connection, and opens it again
  req.send({"e"});
  EXPECT_EQ(req.receive(), Frames{"re:e"});
}

TEST(ControlServer, WorksOverTcp) {
  const std::string endpoint = test::tcp_endpoint();
  const Served served(endpoint);
  RawClient req(ZMQ_REQ, endpoint);
  req.send({"a"});
  EXPECT_EQ(req.receive(), Frames{"re:a"});
}

TEST(ControlServer, AnswersAMebibyteOfGarbageWithOneErrorAndGoesOn) {
  const auto endpoint = test::ipc_endpoint("garbage");
  std::atomic<int> handled{0};
  const Served served(endpoint, [&](std::string_view, const std::string&,
                                    const std::function<void(std::string)>& reply) {
    ++handled;
    reply("ok");
  });
  RawClient dealer(ZMQ_DEALER, endpoint);
  dealer.send({std::string(1 << 20, '\xfe')});
  dealer.send({"x"});
  EXPECT_EQ(dealer.receive(), Frames{"too large"});
  EXPECT_EQ(dealer.receive(), Frames{"ok"});
  EXPECT_EQ(handled, 1);
}

TEST(ControlServer, AnswersSeveralFramesWithOneError) {
  const auto endpoint = test::ipc_endpoint("frames");
  const Served served(endpoint);
  RawClient dealer(ZMQ_DEALER, endpoint);
  dealer.send({"a", "b", "c"});
  EXPECT_EQ(dealer.receive(), Frames{"too large"});
  dealer.send({"", "a", "b", "c"});
  EXPECT_EQ(dealer.receive(), (Frames{"", "too large"}));
  dealer.send(Frames(1000, "a"));
  EXPECT_EQ(dealer.receive(), Frames{"too large"});
  dealer.send({"a"});
  EXPECT_EQ(dealer.receive(), Frames{"re:a"});
}

TEST(ControlServer, HandsAnEmptyFrameOnAndAnswersIt) {
  const auto endpoint = test::ipc_endpoint("empty");
  const Served served(endpoint);
  RawClient dealer(ZMQ_DEALER, endpoint), req(ZMQ_REQ, endpoint);
  dealer.send({""});
  EXPECT_EQ(dealer.receive(), Frames{"re:"});
  dealer.send({"", ""});
  EXPECT_EQ(dealer.receive(), (Frames{"", "re:"}));
  req.send({""});
  EXPECT_EQ(req.receive(), Frames{"re:"});
}

TEST(ControlServer, SendsNothingForAnEmptyReply) {
  const auto endpoint = test::ipc_endpoint("notification");
  const Served served(endpoint, [](std::string_view request, const std::string&,
                                   const std::function<void(std::string)>& reply) {
    reply(request == "silent" ? "" : "ok");
  });
  RawClient dealer(ZMQ_DEALER, endpoint);
  dealer.send({"silent"});
  dealer.send({"x"});
  EXPECT_EQ(dealer.receive(), Frames{"ok"});
  EXPECT_TRUE(dealer.receive(100).empty());
}

TEST(ControlServer, TakesRepliesFromAnyThreadInAnyOrderOnce) {
  const auto endpoint = test::ipc_endpoint("threads");
  std::mutex mutex;
  std::deque<std::pair<std::string, std::function<void(std::string)>>> waiting;
  const Served served(endpoint, [&](std::string_view request, const std::string&,
                                    std::function<void(std::string)> reply) {
    const std::lock_guard lock(mutex);
    waiting.emplace_back(request, std::move(reply));
  });
  RawClient a(ZMQ_DEALER, endpoint), b(ZMQ_DEALER, endpoint);
  for (int k = 0; k < 50; ++k) {
    a.send({"a" + std::to_string(k)});
    b.send({"b" + std::to_string(k)});
  }
  for (std::size_t got = 0; got < 100;) {
    std::this_thread::sleep_for(1ms);
    const std::lock_guard lock(mutex);
    got = waiting.size();
  }
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&] {
      for (;;) {
        std::unique_lock lock(mutex);
        if (waiting.empty()) return;
        auto [request, reply] = std::move(waiting.back());
        waiting.pop_back();
        lock.unlock();
        reply(request);
        reply(request);  // a second call has no effect
      }
    });
  }
  for (auto& thread : threads) thread.join();
  for (auto* client : {&a, &b}) {
    std::vector<std::string> seen;
    for (int k = 0; k < 50; ++k) {
      const auto frames = client->receive();
      ASSERT_EQ(frames.size(), 1u);
      EXPECT_EQ(frames[0][0], client == &a ? 'a' : 'b');
      seen.push_back(frames[0]);
    }
    std::sort(seen.begin(), seen.end());
    EXPECT_EQ(std::unique(seen.begin(), seen.end()), seen.end());
    EXPECT_TRUE(client->receive(50).empty());
  }
}

/// Handler that withholds the replies to all requests except those that begin with "now".
class Held {
 public:
  ControlHandler handler() {
    return [this](const ControlRequest& request, SendReply reply) {
      if (open_ || request.bytes.starts_with("now")) return reply("ok", nullptr);
      const std::lock_guard lock(mutex_);
      replies_.push_back(std::move(reply));
    };
  }
  std::size_t size() {
    const std::lock_guard lock(mutex_);
    return replies_.size();
  }
  void wait_for(std::size_t count) {
    while (size() < count) std::this_thread::sleep_for(1ms);
  }
  void let_go() {
    open_ = true;
    const std::lock_guard lock(mutex_);
    for (auto& reply : replies_) reply("ok", nullptr);
  }

 private:
  std::mutex mutex_;
  std::vector<SendReply> replies_;
  std::atomic<bool> open_{false};
};

TEST(ControlServer, HoldsAClientsNextRequestsBackWhileManyAreCarriedOutAndAnswersOthers) {
  const auto endpoint = test::ipc_endpoint("pending");
  Held held;
  const Served served(endpoint, held.handler());
  RawClient dealer(ZMQ_DEALER, endpoint), other(ZMQ_REQ, endpoint);
  for (int k = 0; k < 1500; ++k) dealer.send({"x"});
  held.wait_for(64);
  for (int k = 0; k < 20; ++k) {
    other.send({"now"});
    ASSERT_EQ(other.receive(), Frames{"ok"});
  }
  EXPECT_EQ(held.size(), 64u);
  held.let_go();
  for (int k = 0; k < 1500; ++k) ASSERT_EQ(dealer.receive(), Frames{"ok"}) << k;
}

TEST(ControlServer, AnswersAClientWhateverManyOthersHavePending) {
  const auto endpoint = test::ipc_endpoint("many");
  Held held;
  const Served served(endpoint, held.handler());
  std::deque<RawClient> others;
  for (int k = 0; k < 3; ++k) {
    others.emplace_back(ZMQ_DEALER, endpoint);
    for (int n = 0; n < 64; ++n) others.back().send({"x"});
  }
  held.wait_for(128);  // the limit of all clients together
  RawClient one(ZMQ_REQ, endpoint);
  one.send({"now"});
  EXPECT_EQ(one.receive(), Frames{"ok"});
  held.let_go();
}

TEST(ControlServer, KeepsFewRepliesThatAreNotReadAndSendsAllOnceTheyAre) {
  const auto endpoint = test::ipc_endpoint("unread");
  constexpr std::size_t kLarge = 1 << 20;
  constexpr int kRequests = 40;
  std::atomic<int> handled{0};
  const Served served(endpoint, [&](std::string_view request, const std::string&,
                                    const std::function<void(std::string)>& reply) {
    if (request == "x") ++handled;
    reply(std::string(request == "x" ? kLarge : 1, 'y'));
  });
  const int few = 1;
  RawClient mute(ZMQ_DEALER, endpoint, "", few);
  for (int k = 0; k < kRequests; ++k) mute.send({"x"});
  RawClient other(ZMQ_REQ, endpoint);
  for (int k = 0; k < 50; ++k) {  // gives the server 50 turns
    other.send({"now"});
    ASSERT_EQ(other.receive(), Frames{"y"});
  }
  EXPECT_LT(handled, kRequests / 2);
  for (int k = 0; k < kRequests; ++k) {
    ASSERT_EQ(mute.receive(), Frames{std::string(kLarge, 'y')}) << k;
  }
  EXPECT_EQ(handled, kRequests);
}

TEST(ControlServer, IsNotHeldUpByClientsThatLeaveOrDoNotRead) {
  const auto endpoint = test::ipc_endpoint("leavers");
  const Served served(endpoint, [](std::string_view, const std::string&,
                                   const std::function<void(std::string)>& reply) {
    reply(std::string(50000, 'y'));
  });
  for (int k = 0; k < 20; ++k) RawClient(ZMQ_DEALER, endpoint).send({"x"});
  RawClient deaf(ZMQ_DEALER, endpoint);
  for (int k = 0; k < 3000; ++k) zmq_send(deaf.handle(), "x", 1, ZMQ_DONTWAIT);
  RawClient good(ZMQ_DEALER, endpoint);
  good.send({"x"});
  EXPECT_EQ(good.receive().size(), 1u);
}

TEST(ControlServer, GivesAStolenRoutingIdNoOneElsesReplies) {
  const auto endpoint = test::ipc_endpoint("identity");
  const Served served(endpoint);
  RawClient first(ZMQ_DEALER, endpoint, "me");
  first.send({"1"});
  EXPECT_EQ(first.receive(), Frames{"re:1"});
  RawClient thief(ZMQ_DEALER, endpoint, "me");
  thief.send({"2"});
  first.send({"3"});
  EXPECT_EQ(first.receive(), Frames{"re:3"});
  EXPECT_TRUE(first.receive(50).empty());
}

TEST(ControlServer, IgnoresRepliesAfterItsEnd) {
  std::function<void(std::string)> late;
  const auto endpoint = test::ipc_endpoint("late");
  Served served(endpoint, [&late](std::string_view, const std::string&,
                                  std::function<void(std::string)> reply) {
    late = std::move(reply);
    late("first");
  });
  RawClient dealer(ZMQ_DEALER, endpoint);
  dealer.send({"x"});
  EXPECT_EQ(dealer.receive(), Frames{"first"});
  served.stop();
  late("second");
}

TEST(ControlServer, SaysWhichEndpointIsInUse) {
  for (const std::string& endpoint : {test::tcp_endpoint(), test::ipc_endpoint("taken")}) {
    const Served served(endpoint);
    const auto second = ControlServer::bind(endpoint, kLimits, Served::echo());
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, Errc::unavailable);
    EXPECT_NE(second.error().reason.find(endpoint + " is in use"), std::string::npos);
    RawClient req(ZMQ_REQ, endpoint);
    req.send({"a"});
    EXPECT_EQ(req.receive(), Frames{"re:a"});  // the first server is not affected
  }
}

TEST(ControlServer, DistinguishesWrongEndpointsFromAbsentOnes) {
  const auto code = [](const char* endpoint) {
    const auto bound = ControlServer::bind(endpoint, kLimits, Served::echo());
    return bound ? Errc::internal : bound.error().code;
  };
  EXPECT_EQ(code("nonsense"), Errc::invalid);
  EXPECT_EQ(code("http://127.0.0.1:1"), Errc::invalid);
  EXPECT_EQ(code("tcp://127.0.0.1"), Errc::invalid);
  EXPECT_EQ(code("tcp://127.0.0.1:99999"), Errc::invalid);
  EXPECT_EQ(code("ipc://"), Errc::invalid);
  EXPECT_EQ(code(("ipc:///tmp/" + std::string(200, 'a')).c_str()), Errc::invalid);
  EXPECT_EQ(code("tcp://192.0.2.1:7702"), Errc::unavailable);
}

TEST(ControlServer, TakesAnIpcPathThatADeadProgramLeft) {
  const auto endpoint = test::ipc_endpoint("stale");
  const std::string path = endpoint.substr(6);
  FILE* file = std::fopen(path.c_str(), "w");
  ASSERT_NE(file, nullptr);
  std::fclose(file);
  const Served served(endpoint);
  RawClient req(ZMQ_REQ, endpoint);
  req.send({"a"});
  EXPECT_EQ(req.receive(), Frames{"re:a"});
}

TEST(ControlClient, GetsAnswersAndGivesUpInTime) {
  const auto endpoint = test::ipc_endpoint("client");
  auto client = ControlClient::connect(endpoint);
  ASSERT_TRUE(client);
  const auto nobody = client->request("early", 100ms);
  ASSERT_FALSE(nobody);
  EXPECT_EQ(nobody.error().code, Errc::unavailable);
  EXPECT_NE(nobody.error().reason.find(endpoint), std::string::npos);
  const Served served(endpoint);
  EXPECT_EQ(client->request("x", 5000ms), "re:x");
  EXPECT_EQ(ControlClient::connect("nonsense").error().code, Errc::invalid);
}

TEST(ControlClient, NeverTakesALateReplyForThatOfAnotherRequest) {
  const auto endpoint = test::ipc_endpoint("late-client");
  std::function<void(std::string)> late;
  std::atomic<bool> asked{false};
  const Served served(endpoint, [&](std::string_view request, const std::string&,
                                    std::function<void(std::string)> reply) {
    if (request == "slow") {
      late = std::move(reply);
      asked = true;
      return;
    }
    late("late");
    reply("second");
  });
  auto client = ControlClient::connect(endpoint);
  ASSERT_TRUE(client);
  while (!asked) EXPECT_FALSE(client->request("slow", 300ms));
  EXPECT_EQ(client->request("fast", 5000ms), "second");
}

TEST(ControlServer, CarriesJsonRpcToAndFro) {
  const auto endpoint = test::ipc_endpoint("rpc");
  const RpcDispatch dispatch = [](const RpcCall& call, const RpcReply& reply) {
    reply(RpcResult{{{"method", call.method}, {"params", call.params}}});
  };
  const Served served(endpoint, [&](const ControlRequest& request, SendReply reply) {
    handle_rpc(request.bytes, request.binary, dispatch, std::move(reply));
  });
  auto client = ControlClient::connect(endpoint);
  ASSERT_TRUE(client);
  const auto reply =
      client->request(R"({"jsonrpc":"2.0","method":"m","params":{"a":1},"id":1})", 5000ms);
  ASSERT_TRUE(reply);
  EXPECT_EQ(Json::parse(*reply).at("result").at("params").at("a"), 1);
}

}  // namespace
}  // namespace ovws
