!> From the addresses of a Fortran array's first elements to the c_array that insitu.h takes: any
!! section, padded or with strides, of rank 1 to 4, in place.
module insitu_arrays
  use, intrinsic :: iso_c_binding, only: c_associated, c_int, c_int64_t, c_intptr_t, &
      c_loc, c_null_ptr, c_ptr, c_sizeof
  use, intrinsic :: iso_fortran_env, only: int64, int8
  use insitu_c, only: c_array, insitu_uint8
  implicit none
  private

  public :: array_of, nothing, view_of_bytes

contains

  !> at(0) is the first element's address, at(d) that of its neighbour along dimension d (the same
  !! where the extent is 1). With `vector`, the first dimension holds the components of one item;
  !! the others, Fortran's first index fastest, number the items.
  function array_of(type, extents, at, vector) result(array)
    integer(c_int), intent(in) :: type
    integer, intent(in) :: extents(:)
    type(c_ptr), intent(in) :: at(0:)
    logical, intent(in), optional :: vector
    type(c_array) :: array
    integer(int64) :: extent(3), stride(3), step
    integer :: d, n, first

    array%size = c_sizeof(array)
    array%type = type
    first = 1
    if (present(vector)) first = merge(2, 1, vector)
    if (first == 2) array%components = int(extents(1), c_int)
    array%count = product(int(extents(first:), int64))
    if (.not. c_associated(at(0))) return                ! an empty array has no elements to show
    array%data = at(0)
    if (first == 2) array%component_stride = bytes_between(at(0), at(1))

    ! Dimensions that follow on each other in memory are one: t(:, 2:9) is a single run of items.
    n = 0
    do d = first, size(extents)
      if (extents(d) == 1) cycle
      step = bytes_between(at(0), at(d))
      if (n > 0) then
        if (step == stride(n) * extent(n)) then
          extent(n) = extent(n) * extents(d)
          cycle
        end if
      end if
      n = n + 1
      extent(n) = extents(d)
      stride(n) = step
    end do
    array%stride(:n) = stride(:n)
    if (n > 1) then
      array%extent = 1
      array%extent(:n) = extent(:n)
    end if
  end function array_of

  !> For a pointer that is not associated: what insitu.h refuses as null.
  function nothing() result(array)
    type(c_array) :: array
    array%size = c_sizeof(array)
    array%count = 1
  end function nothing

  !> Types of cells, ghost bits: Fortran's int8 for C's uint8, the same bits.
  function view_of_bytes(a) result(array)
    integer(int8), pointer, intent(in) :: a(:)
    type(c_array) :: array
    type(c_ptr) :: at(0:1)
    integer :: l(1), n(1)

    if (.not. associated(a)) then
      array = nothing()
      return
    end if
    at = c_null_ptr
    l = lbound(a)
    n = l + min(1, shape(a) - 1)                          ! the neighbours, where there are some
    if (size(a) > 0) then
      at(0) = c_loc(a(l(1)))
      at(1) = c_loc(a(n(1)))
    end if
    array = array_of(insitu_uint8, shape(a), at)
  end function view_of_bytes

  integer(c_int64_t) function bytes_between(from, to)
    type(c_ptr), intent(in) :: from, to
    bytes_between = transfer(to, 0_c_intptr_t) - transfer(from, 0_c_intptr_t)
  end function bytes_between

end module insitu_arrays
