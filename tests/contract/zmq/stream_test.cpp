#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "drivers/zmq/client.hpp"
#include "drivers/zmq/publisher.hpp"
#include "tests/contract/zmq/endpoints.hpp"

namespace ovws {
namespace {

using namespace std::chrono_literals;

Publisher publisher_at(const std::string& endpoint, int send_queue) {
  auto bound = Publisher::bind(endpoint, send_queue);
  EXPECT_TRUE(bound) << bound.error().reason;
  return std::move(bound.value());
}

Subscriber subscriber_at(const std::string& endpoint, const std::vector<std::string>& topics,
                         int receive_queue) {
  auto connected = Subscriber::connect(endpoint, topics, receive_queue);
  EXPECT_TRUE(connected);
  return std::move(connected.value());
}

/// Publishes on the topic until the subscriber receives it; from then on nothing is lost. Takes
/// what was published for that, up to a last message.
void settle(Publisher& publisher, Subscriber& subscriber, const std::string& topic) {
  static int last = 0;
  const std::string settled = "settled " + std::to_string(++last);
  for (int k = 0; k < 500; ++k) {
    publisher.send(topic, "hello");
    if (subscriber.receive(10ms)) break;
  }
  publisher.send(topic, settled);
  while (const auto taken = subscriber.receive(5000ms)) {
    if (taken->json == settled) return;
  }
}

/// The next message of a topic.
std::optional<StreamMessage> next_of(Subscriber& subscriber, const std::string& topic,
                                     std::chrono::milliseconds timeout) {
  auto message = subscriber.receive(timeout);
  while (message && message->topic != topic) message = subscriber.receive(timeout);
  return message;
}

TEST(Publisher, SendsTopicJsonAndBinary) {
  const auto endpoint = test::ipc_endpoint("parts");
  Publisher publisher = publisher_at(endpoint, 10);
  Subscriber subscriber = subscriber_at(endpoint, {}, 10);
  settle(publisher, subscriber, "t");
  const std::vector<std::byte> bytes{std::byte{1}, std::byte{0}, std::byte{255}};
  EXPECT_TRUE(publisher.send("spots", "{}", bytes));
  EXPECT_TRUE(publisher.send("wavefront", "{\"a\":1}"));
  const auto spots = subscriber.receive(5000ms);
  ASSERT_TRUE(spots);
  EXPECT_EQ(spots->topic, "spots");
  EXPECT_EQ(spots->json, "{}");
  EXPECT_EQ(spots->binary, bytes);
  const auto wavefront = subscriber.receive(5000ms);
  ASSERT_TRUE(wavefront);
  EXPECT_EQ(wavefront->json, "{\"a\":1}");
  EXPECT_TRUE(wavefront->binary.empty());
}

TEST(Publisher, SendsOverIpv6) {
  const auto endpoint = test::ipv6_endpoint();
  if (endpoint.empty()) GTEST_SKIP() << "this machine has no IPv6";
  Publisher publisher = publisher_at(endpoint, 10);
  Subscriber subscriber = subscriber_at(endpoint, {"event"}, 10);
  settle(publisher, subscriber, "event");
  publisher.send("event", "1");
  const auto message = subscriber.receive(5000ms);
  ASSERT_TRUE(message);
  EXPECT_EQ(message->json, "1");
}

TEST(Publisher, SendsASubscriberItsTopicsOnly) {
  const auto endpoint = test::ipc_endpoint("topics");
  Publisher publisher = publisher_at(endpoint, 10);
  Subscriber subscriber = subscriber_at(endpoint, {"event", "status"}, 10);
  settle(publisher, subscriber, "event");
  for (const char* topic : {"wavefront", "status.b", "status", "status.c"})  // some begin alike
    publisher.send(topic, topic);
  const auto message = subscriber.receive(5000ms);
  ASSERT_TRUE(message);
  EXPECT_EQ(message->json, "status");
  EXPECT_FALSE(subscriber.receive(50ms));
}

TEST(Publisher, ASlowSubscriberLosesItsOwnMessagesOnly) {
  const auto endpoint = test::ipc_endpoint("slow");
  Publisher publisher = publisher_at(endpoint, 64);
  Subscriber slow = subscriber_at(endpoint, {}, 2);
  Subscriber quick = subscriber_at(endpoint, {}, 2000);
  settle(publisher, quick, "t");
  settle(publisher, slow, "t");
  const std::vector<std::byte> picture(256 * 1024);  // larger than the kernel's buffers
  constexpr int kMessages = 200;
  // In step with the fast subscriber, so that only the slow one's queue fills, even on a busy
  // machine.
  for (int k = 0; k < kMessages; ++k) {
    EXPECT_TRUE(publisher.send("image", std::to_string(k), picture));
    const auto message = next_of(quick, "image", 5000ms);
    ASSERT_TRUE(message) << "lost " << k;
    EXPECT_EQ(message->json, std::to_string(k));
    std::this_thread::sleep_for(1ms);  // libzmq updates its queue count with a delay
  }
  int kept = 0;
  while (const auto message = next_of(slow, "image", 200ms)) {
    EXPECT_EQ(message->binary.size(), picture.size());  // whole messages, or none
    ++kept;
  }
  EXPECT_GT(kept, 0);
  EXPECT_LT(kept, kMessages);
}

TEST(Publisher, SendingWithoutASubscriberNeverBlocks) {
  Publisher publisher = publisher_at(test::ipc_endpoint("nobody"), 1);
  for (int k = 0; k < 100000; ++k) ASSERT_TRUE(publisher.send("t", "{}"));
}

TEST(Publisher, SaysWhichEndpointIsInUse) {
  for (const std::string& endpoint : {test::tcp_endpoint(), test::ipc_endpoint("taken-stream")}) {
    const Publisher first = publisher_at(endpoint, 1);
    const auto second = Publisher::bind(endpoint, 1);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, Errc::unavailable);
    EXPECT_NE(second.error().reason.find(endpoint + " is in use"), std::string::npos);
  }
  EXPECT_EQ(Publisher::bind("tcp:127.0.0.1", 1).error().code, Errc::invalid);
}

TEST(Publisher, CanBeMoved) {
  const auto endpoint = test::ipc_endpoint("moved");
  Publisher publisher = publisher_at(endpoint, 10);
  Publisher moved = std::move(publisher);
  Subscriber subscriber = subscriber_at(endpoint, {}, 10);
  settle(moved, subscriber, "t");
  moved.send("t", "x");
  EXPECT_TRUE(subscriber.receive(5000ms));
}

}  // namespace
}  // namespace ovws
