!> Strings across the ABI, and frames of reference written as text.
module insitu_text
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_int32_t, c_null_char, &
      c_ptr, c_sizeof
  use insitu_c
  implicit none
  private

  public :: to_c, from_c, read_frame

contains

  !> Without trailing blanks, with the null at the end that C wants.
  function to_c(text) result(c)
    character(len=*), intent(in) :: text
    character(kind=c_char, len=:), allocatable :: c
    c = trim(text) // c_null_char
  end function to_c

  function from_c(address) result(text)
    type(c_ptr), intent(in) :: address
    character(len=:), allocatable :: text
    character(kind=c_char), pointer :: characters(:)
    integer :: i, length

    length = 0
    if (c_associated(address)) length = int(c_strlen(address))
    allocate (character(len=length) :: text)
    if (length == 0) return
    call c_f_pointer(address, characters, [length])
    do i = 1, length
      text(i:i) = characters(i)
    end do
  end function from_c

  !> 'cartesian', 'geocentric', 'geodetic', 'enu <longitude> <latitude> <height>' or
  !! 'utm <zone>N' (S: south of the equator). After 'geodetic' any of the words radians (else
  !! degrees), kilometres (else metres) and depth (else height). good is false for anything else.
  subroutine read_frame(text, frame, good)
    character(len=*), intent(in) :: text
    type(c_frame), intent(out) :: frame
    logical, intent(out) :: good
    character(len=:), allocatable :: kind, rest
    integer :: blank, status, hemisphere

    frame%size = c_sizeof(frame)
    kind = trim(adjustl(text))
    blank = index(kind // ' ', ' ')
    rest = adjustl(kind(blank:))
    kind = kind(:blank - 1)
    good = len_trim(rest) == 0
    select case (kind)
    case ('cartesian')
      frame%kind = insitu_frame_cartesian
    case ('geocentric')
      frame%kind = insitu_frame_geocentric
    case ('geodetic')
      frame%kind = insitu_frame_geodetic
      call read_units(rest, frame, good)
    case ('enu')
      frame%kind = insitu_frame_enu
      read (rest, *, iostat=status) frame%origin
      good = status == 0
    case ('utm')
      frame%kind = insitu_frame_utm
      hemisphere = scan(rest, 'NS')
      good = hemisphere > 1 .and. hemisphere == len_trim(rest)
      if (.not. good) return
      read (rest(:hemisphere - 1), *, iostat=status) frame%utm_zone
      good = status == 0
      frame%utm_north = merge(1_c_int32_t, 0_c_int32_t, rest(hemisphere:hemisphere) == 'N')
    case default
      good = .false.
    end select
  end subroutine read_frame

  !> The words after 'geodetic'.
  subroutine read_units(words, frame, good)
    character(len=*), intent(in) :: words
    type(c_frame), intent(inout) :: frame
    logical, intent(out) :: good
    character(len=:), allocatable :: rest
    integer :: blank

    good = .true.
    rest = trim(adjustl(words))
    do while (good .and. len(rest) > 0)
      blank = index(rest // ' ', ' ')
      select case (rest(:blank - 1))
      case ('degrees')
        frame%angle = insitu_degrees
      case ('radians')
        frame%angle = insitu_radians
      case ('metres')
        frame%length = insitu_metres
      case ('kilometres')
        frame%length = insitu_kilometres
      case ('height')
        frame%vertical = insitu_up
      case ('depth')
        frame%vertical = insitu_down
      case default
        good = .false.
      end select
      rest = trim(adjustl(rest(blank:)))
    end do
  end subroutine read_units

end module insitu_text
