// SPDX-License-Identifier: GPL-3.0-or-later
// The assembler includes the files unchanged: this is faster than a megabyte of source text, and the same with GCC and
// Clang.
#include "page/embedded.h"

// clang-format off
#define ST_EMBED(symbol, path)                             \
  __asm__(".section .rodata\n"                             \
          ".global " #symbol "_begin\n.global " #symbol "_end\n" \
          #symbol "_begin:\n.incbin \"" path "\"\n"        \
          #symbol "_end:\n.byte 0\n.previous\n");          \
  extern "C" const char symbol##_begin[], symbol##_end[];
// clang-format on

ST_EMBED(spheretree_page_css, SPHERETREE_PAGE_DIR "/page.css")
ST_EMBED(spheretree_page_js, SPHERETREE_PAGE_DIR "/page.js")
ST_EMBED(spheretree_view_js, SPHERETREE_PAGE_DIR "/view.js")
ST_EMBED(spheretree_compare_js, SPHERETREE_PAGE_DIR "/compare.js")
ST_EMBED(spheretree_report_js, SPHERETREE_PAGE_DIR "/report.js")
ST_EMBED(spheretree_three_js, SPHERETREE_THREE_JS)

namespace spheretree::tool::embedded {

std::string_view pageStyle() { return {spheretree_page_css_begin, spheretree_page_css_end}; }
std::string_view pageScript() { return {spheretree_page_js_begin, spheretree_page_js_end}; }
std::string_view viewScript() { return {spheretree_view_js_begin, spheretree_view_js_end}; }
std::string_view compareScript() { return {spheretree_compare_js_begin, spheretree_compare_js_end}; }
std::string_view reportScript() { return {spheretree_report_js_begin, spheretree_report_js_end}; }
std::string_view three() { return {spheretree_three_js_begin, spheretree_three_js_end}; }

}  // namespace spheretree::tool::embedded
