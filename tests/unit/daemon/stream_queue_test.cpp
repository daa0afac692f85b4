#include "daemon/ovwsd/actor/stream_queue.hpp"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace ovws {
namespace {

std::uint64_t seq_of(const StreamQueue::Message& message) {
  if (const auto* event = std::get_if<EventMessage>(&message)) return event->seq;
  if (const auto* status = std::get_if<StatusMessage>(&message)) return status->seq;
  return std::get<RefinedMessage>(message).seq;
}

std::vector<std::uint64_t> seqs_of_events(StreamQueue& queue) {
  std::vector<std::uint64_t> seqs;
  while (auto message = queue.take()) {
    if (std::holds_alternative<EventMessage>(*message)) seqs.push_back(seq_of(*message));
  }
  return seqs;
}

TEST(StreamQueue, NumbersEachTopicFromZero) {
  StreamQueue queue;
  queue.put(EventMessage{});
  queue.put(StatusMessage{});
  queue.put(EventMessage{});
  queue.put(RefinedMessage{});
  std::vector<std::uint64_t> seqs;
  while (auto message = queue.take()) seqs.push_back(seq_of(*message));
  EXPECT_EQ(seqs, (std::vector<std::uint64_t>{0, 0, 1, 0}));
  EXPECT_EQ(queue.take_dropped(), 0u);
}

TEST(StreamQueue, CountsWhatItDropsAndLeavesAHoleInTheNumbers) {
  StreamQueue queue;
  queue.put(EventMessage{});
  EXPECT_EQ(seqs_of_events(queue), std::vector<std::uint64_t>{0});
  constexpr std::uint64_t kEvents = 1000;
  for (std::uint64_t k = 0; k < kEvents; ++k) queue.put(EventMessage{});
  const std::uint64_t dropped = queue.take_dropped();
  EXPECT_GT(dropped, 0u);
  EXPECT_EQ(queue.take_dropped(), 0u);
  const auto seqs = seqs_of_events(queue);
  ASSERT_EQ(seqs.size(), kEvents - dropped);
  EXPECT_EQ(seqs.front(), 1 + dropped);
  EXPECT_EQ(seqs.back(), kEvents);
}

TEST(StreamQueue, LosesNothingWhileOthersPut) {
  StreamQueue queue;
  constexpr std::uint64_t kEvents = 200;  // fewer than the queue holds
  std::thread other([&queue] {
    for (std::uint64_t k = 0; k < kEvents; ++k) queue.put(EventMessage{});
  });
  std::vector<std::uint64_t> seqs;
  while (seqs.size() < kEvents) {
    const auto more = seqs_of_events(queue);
    seqs.insert(seqs.end(), more.begin(), more.end());
  }
  other.join();
  EXPECT_TRUE(queue.is_empty());
  for (std::uint64_t k = 0; k < kEvents; ++k) EXPECT_EQ(seqs[k], k);
}

}  // namespace
}  // namespace ovws
