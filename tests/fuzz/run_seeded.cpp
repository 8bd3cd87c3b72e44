// SPDX-License-Identifier: Apache-2.0
// Runs a fuzz target without libFuzzer: mutates its seeds a fixed number of times from a fixed seed, the same on every
// machine.
//   TARGET EXECUTIONS [SEED]     TARGET --write-seeds FOLDER (a corpus for libFuzzer)     TARGET --replay FILE (a
//   finding)
// A target that stops leaves its input as FINDING in the working folder.
#include <algorithm>
#include <csignal>
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>

#include "fuzz/fuzz_target.h"
#include "support/random.h"

namespace {

std::string input;

extern "C" void keepInput(int signal) {
  std::ofstream("FINDING", std::ios::binary).write(input.data(), static_cast<std::streamsize>(input.size()));
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void mutate(std::string& text, const std::vector<std::string>& seeds, spheretree::test::Random& random) {
  static constexpr std::uint32_t kEdgeValues[] = {
      0,          1,          0x7f,       0x80,       0xff,       0x7fff,     0xffff,
      0x7fffffff, 0x80000000, 0xffffffff, 0x7f800000, 0x7fc00000, 0x00000001, 0x3f800000};  // also floats: inf, NaN, tiny, 1
  const auto at = [&] { return random.below(text.size() + 1); };
  switch (random.below(7)) {
    case 0:
      if (!text.empty()) text[random.below(text.size())] ^= static_cast<char>(1u << random.below(8));
      break;
    case 1:
      if (!text.empty()) text[random.below(text.size())] = static_cast<char>(random.next());
      break;
    case 2: {
      const std::uint32_t value = kEdgeValues[random.below(std::size(kEdgeValues))];
      if (text.size() >= 4) std::memcpy(text.data() + random.below(text.size() - 3) / 4 * 4, &value, sizeof value);
      break;
    }
    case 3:
      text.resize(at());
      break;
    case 4: {
      const std::size_t first = at();
      text.erase(first, random.below(16));
      break;
    }
    case 5: {
      const std::size_t first = at(), from = at(), count = random.below(64);
      text.insert(first, text.substr(from, count));
      break;
    }
    default: {
      const std::string& other = seeds[random.below(seeds.size())];
      const std::size_t keep = at(), from = random.below(other.size() + 1);
      text = text.substr(0, keep) + other.substr(from);
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> seeds = spheretree::fuzz::seeds();
  const std::string command = argc > 1 ? argv[1] : "";
  if (argc == 3 && command == "--write-seeds") {
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      std::ofstream file(std::string(argv[2]) + "/seed_" + std::to_string(i), std::ios::binary);
      file << seeds[i];
      if (!file.flush()) return 1;
    }
    return 0;
  }
  for (const int signal : {SIGABRT, SIGSEGV, SIGFPE}) std::signal(signal, keepInput);
  const auto run = [](const std::string& text) {
    input = text;
    const std::vector<std::uint8_t> own(text.begin(), text.end());  // exact size: a sanitizer sees an over-read
    LLVMFuzzerTestOneInput(own.data(), own.size());
  };
  if (argc == 3 && command == "--replay") {
    std::ifstream file(argv[2], std::ios::binary);
    run({std::istreambuf_iterator<char>(file), {}});
    return 0;
  }
  const unsigned long executions = std::strtoul(command.c_str(), nullptr, 10);
  if (executions == 0) {
    std::cerr << "usage: " << argv[0] << " EXECUTIONS [SEED] | --write-seeds FOLDER | --replay FILE\n";
    return 2;
  }
  spheretree::test::Random random(argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1);
  for (const std::string& seed : seeds) run(seed);
  for (unsigned long i = 0; i < executions; ++i) {
    std::string text = seeds[random.below(seeds.size())];
    for (std::uint64_t k = 0; k <= random.below(4); ++k) mutate(text, seeds, random);
    run(text);
  }
  std::cout << executions << " executions, nothing broken\n";
  return 0;
}
