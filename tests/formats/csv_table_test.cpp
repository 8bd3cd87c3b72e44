// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/csv_table.h"

#include <gtest/gtest.h>

#include <string>

#include "spheretree/formats/errors.h"
#include "support/random.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

TEST(CsvTable, ReadsRowsByTheNamesOfTheirColumns) {
  CsvTable table("b, a ,c\r\n1,2,x\r\n\r\n 3 ,-4.5e-1,\r\n", "in.csv");
  EXPECT_EQ(table.columns(), (std::vector<std::string_view>{"b", "a", "c"}));
  const std::size_t a = table.require("a", "-"), b = table.require("b", "-");
  EXPECT_FALSE(table.find("d").has_value());
  ASSERT_TRUE(table.next());
  EXPECT_EQ(table.number(a), 2);
  EXPECT_EQ(table.count(b, 9), 1u);
  EXPECT_EQ(table.field(2), "x");
  ASSERT_TRUE(table.next());
  EXPECT_EQ(table.number(a), -0.45);
  EXPECT_EQ(table.count(b, 9), 3u);
  EXPECT_EQ(table.field(2), "");
  EXPECT_FALSE(table.next());
  EXPECT_FALSE(table.next());
}

TEST(CsvTable, TakesEveryEndOfLine) {
  for (const std::string end : {"\n", "\r\n", "\r"}) {
    const std::string text = "a,b" + end + "1,2" + end + "3,4";
    CsvTable table(text, "in.csv");
    int rows = 0;
    for (; table.next(); ++rows) EXPECT_EQ(table.number(1), 2 * rows + 2);
    EXPECT_EQ(rows, 2);
  }
}

TEST(CsvTable, NamesThePlaceOfWhatIsWrong) {
  const auto refusal = [](const std::string& row) {
    const std::string text = "n,x\n\n" + row;
    return test::refusalOf<FormatError>([&] {
      CsvTable table(text, "in.csv");
      while (table.next()) table.count(0, 7), table.number(1, 100);
    });
  };
  EXPECT_EQ(refusal("7,100"), "");
  EXPECT_EQ(refusal("1,2,3"), "in.csv, line 3: 3 fields, the header has 2");
  EXPECT_EQ(refusal("1"), "in.csv, line 3: 1 field, the header has 2");
  for (const char* bad : {"8", "-1", "1.5", "", "x", "99999999999999999999"})
    EXPECT_EQ(refusal(std::string(bad) + ",1"),
              "in.csv, line 3: column 1 (n) is \"" + std::string(bad) + "\": write a whole number from 0 to 7");
  for (const char* bad : {"", "x", "1x", "0x1"})
    EXPECT_EQ(refusal("1," + std::string(bad)), "in.csv, line 3: column 2 (x) is \"" + std::string(bad) + "\": write a number");
  for (const char* bad : {"101", "nan", "-inf"})
    EXPECT_EQ(refusal("1," + std::string(bad)),
              "in.csv, line 3: column 2 (x) is \"" + std::string(bad) + "\": write a finite number within 100");
  EXPECT_EQ(test::refusalOf<FormatError>([] { CsvTable("", "in.csv"); }),
            "in.csv: the file is empty: begin with a line that names the columns");
  EXPECT_EQ(test::refusalOf<FormatError>([] { CsvTable("a,b\n", "in.csv").require("c", "add it"); }),
            "in.csv, line 1: there is no column c: add it");
}

TEST(CsvTable, SemicolonsSeparateNumbersInAField) {
  CsvTable table("a\n1;-2.5;3e2\n\n7;\nx;1\n", "t.csv");
  ASSERT_TRUE(table.next());
  EXPECT_EQ(table.numbers(0), (std::vector<double>{1, -2.5, 300}));
  EXPECT_EQ(test::refusalOf<FormatError>([&] { table.numbers(0, 360 - 61); }),
            "t.csv, line 2: column 1 (a) is \"1;-2.5;3e2\": write numbers within 299, separated by semicolons");
  ASSERT_TRUE(table.next());
  EXPECT_EQ(table.numbers(0), std::vector<double>{7});
  ASSERT_TRUE(table.next());
  EXPECT_THROW(table.numbers(0), FormatError);
}

TEST(CsvTable, FieldsComeBackAsTheyWere) {
  std::string all;
  for (int c = 1; c < 256; ++c) all += static_cast<char>(c);
  const std::string field = encodedField(all);
  EXPECT_EQ(field.find_first_of(",\"\n\r\t "), std::string::npos);
  EXPECT_EQ(decodedField(field), all);
  EXPECT_EQ(decodedField("100%"), "100%");  // what no encodedField() writes stays as it is
  EXPECT_EQ(decodedField("%2"), "%2");
  EXPECT_EQ(decodedField("%zz"), "%zz");
}

/// For any bytes: rows of the right size, or a refusal.
TEST(CsvTable, TakesOrRefusesAnything) {
  test::Random random(3);
  for (int round = 0; round < 3000; ++round) {
    std::string text = "a,b\n1,2\n3,4\n";
    for (int k = 0; k < 3; ++k) text[random.below(text.size())] = std::string_view(",\n\r\0x1 .-e", 11)[random.below(11)];
    try {
      CsvTable table(text, "in.csv");
      while (table.next()) EXPECT_EQ(table.field(table.columns().size() - 1).find(','), std::string_view::npos);
    } catch (const FormatError& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with("in.csv")) << error.what();
    }
  }
}

}  // namespace
}  // namespace spheretree::formats
