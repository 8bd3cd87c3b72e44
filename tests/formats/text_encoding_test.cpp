// SPDX-License-Identifier: Apache-2.0
#include "text/text_encoding.h"

#include <gtest/gtest.h>

#include <string>

#include "spheretree/formats/errors.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

TEST(AsText, RemovesAMarkAndRefusesWideText) {
  using namespace std::string_literals;
  const auto textOf = [](const std::string& bytes) {
    const std::span<const char> text = asText(test::charsOf(bytes), "a.obj");
    return std::string(text.begin(), text.end());
  };
  for (const std::string& plain : {""s, "v"s, "v 1 2 3"s, "\xef\xbb"s, "\xff"s}) EXPECT_EQ(textOf(plain), plain);
  EXPECT_EQ(textOf("\xef\xbb\xbfv 1"), "v 1");
  for (const std::string& wide : {"\xff\xfev\0"s, "\xfe\xff\0v"s, "\0v"s, "v\0"s, "\0\0\xfe\xff"s})
    EXPECT_TRUE(test::has(test::refusalOf<FormatError>([&] { (void)textOf(wide); }), "a.obj: is UTF-16 or UTF-32 text"));
}

}  // namespace
}  // namespace spheretree::formats
