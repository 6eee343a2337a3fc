// NumPy arrays that own the C++ vectors behind them: no copies.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <memory>
#include <utility>
#include <vector>

namespace firn::python {

namespace py = pybind11;

template <class Number, class Element>
py::array_t<Number> owning_array(std::vector<Element>&& values,
                                 const std::vector<py::ssize_t>& shape) {
  auto owner = std::make_unique<std::vector<Element>>(std::move(values));
  auto* data = reinterpret_cast<Number*>(owner->data());
  py::capsule capsule(owner.get(), [](void* p) { delete static_cast<std::vector<Element>*>(p); });
  owner.release();
  return py::array_t<Number>(shape, data, capsule);
}

// [n]
template <class Number>
py::array_t<Number> array_of(std::vector<Number> values) {
  const auto n = static_cast<py::ssize_t>(values.size());
  return owning_array<Number>(std::move(values), {n});
}

// [n, Width]
template <class Number, std::size_t Width>
py::array_t<Number> array_of(std::vector<std::array<Number, Width>> rows) {
  static_assert(sizeof(std::array<Number, Width>) == Width * sizeof(Number));
  const auto n = static_cast<py::ssize_t>(rows.size());
  return owning_array<Number>(std::move(rows), {n, static_cast<py::ssize_t>(Width)});
}

// [n, columns], row by row
inline py::array_t<double> table_of(std::vector<double> values, std::size_t columns) {
  const auto n = static_cast<py::ssize_t>(columns == 0 ? 0 : values.size() / columns);
  return owning_array<double>(std::move(values), {n, static_cast<py::ssize_t>(columns)});
}

}  // namespace firn::python
