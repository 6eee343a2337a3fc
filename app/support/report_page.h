// The page of whatever a path names: a results file, a study or a validation.
#pragma once

#include <filesystem>
#include <string>

#include "reports/documents/validation_page.h"
#include "reports/html/page.h"

namespace firn {

// The last part of the path of a folder.
std::string folder_name(const std::string& folder);

// Of a folder without results.json: the page of the study, validation or sweep in progress. Throws
// InputError for a path that is none of them.
page::Page report_page(const std::string& path, const ValidationPageOptions& options);

// Makes report.html in the folder of an ended study or validation; its name, or nothing and a line
// on standard error when it could not be made (without gnuplot). Throws WriteError.
std::string write_folder_page(const std::string& folder);

// RUN.html, or report.html in the folder.
std::filesystem::path default_report_file(const std::string& path);

}  // namespace firn
