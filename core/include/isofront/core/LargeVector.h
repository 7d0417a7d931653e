#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace isofront::core {

/// Memory for large arrays of plain numbers. What is large is asked for in pages as large as the
/// system has them, and elements that are made without a value are left as the memory is: an array
/// that is about to be written needn't be cleared first.
/// @tparam T  trivially copyable
template <typename T>
class LargeAllocator {
public:
    using value_type = T;

    LargeAllocator() = default;
    template <typename U>
    LargeAllocator(const LargeAllocator<U>& /*other*/) noexcept // as containers need it
    {
    }

    [[nodiscard]] T* allocate(std::size_t count);
    void deallocate(T* memory, std::size_t count) noexcept;

    template <typename U>
    void construct(U* place) noexcept
    {
        ::new (static_cast<void*>(place)) U;
    }
    template <typename U, typename... Arguments>
    void construct(U* place, Arguments&&... arguments)
    {
        ::new (static_cast<void*>(place)) U(std::forward<Arguments>(arguments)...);
    }

    bool operator==(const LargeAllocator& /*other*/) const { return true; }
};

/// A std::vector for millions of elements: `resize` makes room and leaves it unset.
template <typename T>
using LargeVector = std::vector<T, LargeAllocator<T>>;

namespace detail {
/// Throws std::bad_alloc.
void* allocateLarge(std::size_t bytes, std::size_t alignment);
void freeLarge(void* memory, std::size_t bytes, std::size_t alignment) noexcept;
} // namespace detail

template <typename T>
T* LargeAllocator<T>::allocate(std::size_t count)
{
    if (count > static_cast<std::size_t>(-1) / 2 / sizeof(T))
        throw std::bad_array_new_length();
    return static_cast<T*>(detail::allocateLarge(count * sizeof(T), alignof(T)));
}

template <typename T>
void LargeAllocator<T>::deallocate(T* memory, std::size_t count) noexcept
{
    detail::freeLarge(memory, count * sizeof(T), alignof(T));
}

} // namespace isofront::core
