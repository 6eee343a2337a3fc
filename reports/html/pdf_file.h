// Pages as PDF files.
#pragma once

#include <string>

#include "reports/html/page.h"

namespace firn {

// The page as a PDF of A4 sheets, printed by an installed Chromium or Chrome. Replaces an older
// file atomically. Throws InputError without such a browser, RunError when it fails or takes more
// than two minutes of processor time, WriteError when the file cannot be written.
void write_pdf(const page::Page& page, const std::string& file);

}  // namespace firn
