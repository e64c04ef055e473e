-- SPDX-License-Identifier: Apache-2.0
--
-- Memory of a write and a read port, in a form that GHDL and Yosys map to block RAM of ECP5 and iCE40. No
-- initial contents; what is read in the clock in which the same word is written is undefined.
--
-- Model: block_ram.py.  Test: test_block_ram.py.  Latency: read_stages enabled cycles.  A word in and out per
-- cycle. A memory of many blocks needs three at 100 MHz: a block's word comes late in the cycle, its register
-- stands beside it, and behind the multiplexer of all banks stands the last one. A memory of the whole device
-- needs five: on the ways to its blocks and from them is nothing but wires.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.memory_pkg.all;

entity block_ram is
  generic (
    num_words : positive := 512;
    data_bits : positive := 16;
    -- What a block RAM of ECP5 holds a bit wide. A memory is made of banks of that size, and of halves of it
    -- for what is left, so that every bank is as deep as its blocks and has no multiplexer of its own.
    bank_words : positive := 16384;
    -- Bits that one block may hold of a memory of one bank. ECP5 has a register behind a block up to 18.
    slice_bits : positive := 4096;
    -- 2: the block's own register and that behind the banks; 3: one of each bank between them; 4: both ports
    -- are registers first, a write's too; 5: two of each bank, the second anywhere on the way.
    read_stages : positive := 2
  );
  port (
    clk : in std_ulogic;
    write_enable : in std_ulogic;
    -- Both addresses are below num_words.
    write_address : in u_unsigned(address_bits(num_words) - 1 downto 0);
    write_data : in std_ulogic_vector(data_bits - 1 downto 0);
    -- Moves all registers of the read port.
    read_enable : in std_ulogic;
    read_address : in u_unsigned(address_bits(num_words) - 1 downto 0);
    read_data : out std_ulogic_vector(data_bits - 1 downto 0)
  );
end entity;

architecture rtl of block_ram is

  constant least_words : positive := maximum(bank_words / 16, 1);

  -- Words of the bank that begins with `rest` words left: a power of two, but for a small last one.
  function words_of(rest : positive) return positive is
    variable words : positive := bank_words;
  begin
    if rest <= least_words then
      return rest;
    end if;
    while words > rest loop
      words := words / 2;
    end loop;
    return words;
  end function;

  function count_banks return positive is
    variable rest : natural := num_words;
    variable banks : natural := 0;
  begin
    while rest > 0 loop
      rest := rest - words_of(rest);
      banks := banks + 1;
    end loop;
    return banks;
  end function;

  constant num_banks : positive := count_banks;

  subtype bank_t is natural range 0 to num_banks - 1;
  type fetched_t is array (bank_t) of std_ulogic_vector(data_bits - 1 downto 0);
  signal fetched, banked, carried : fetched_t;
  signal read_reg : std_ulogic_vector(data_bits - 1 downto 0);
  -- The bank of what is fetched; that of what goes to the last register: one bit of each, for a multiplexer
  -- of two levels of LUTs.
  signal bank_read, bank_banked, bank_shown : std_ulogic_vector(bank_t) := (others => '0');

  -- First words of the banks, and their end. Each first word is a multiple of its bank's size.
  type bases_t is array (0 to num_banks) of natural;

  function find_bases return bases_t is
    variable bases : bases_t := (others => 0);
  begin
    for bank in bank_t loop
      bases(bank + 1) := bases(bank) + words_of(num_words - bases(bank));
    end loop;
    return bases;
  end function;

  constant bases : bases_t := find_bases;

  -- Bits of a block that is as deep as a bank. Left alone, synthesis saves a block here and there by others,
  -- less deep, and a multiplexer behind them. A memory of one bank may do so.
  function block_bits(size : positive) return positive is
  begin
    if num_banks = 1 then
      return minimum(slice_bits, data_bits);
    elsif size > bank_words / 2 then
      return 1;
    elsif size > bank_words / 4 then
      return 2;
    elsif size > bank_words / 8 then
      return 4;
    elsif size > bank_words / 16 then
      return 9;
    end if;
    return 18;
  end function;

  -- Whether a word is in a bank: the bits above those within it are those of its first word.
  function is_in(address : u_unsigned; bank : bank_t) return boolean is
    constant place_bits : positive := address_bits(bases(bank + 1) - bases(bank));
  begin
    return shift_right(address, place_bits) = bases(bank) / 2 ** place_bits;
  end function;

  function banks_of(address : u_unsigned) return std_ulogic_vector is
    variable found : std_ulogic_vector(bank_t) := (others => '0');
  begin
    for bank in bank_t loop
      if num_banks = 1 or is_in(address, bank) then
        found(bank) := '1';
      end if;
    end loop;
    return found;
  end function;

  function chosen(words : fetched_t; banks : std_ulogic_vector(bank_t)) return std_ulogic_vector is
    variable word : std_ulogic_vector(data_bits - 1 downto 0) := (others => '0');
  begin
    if num_banks = 1 then
      return words(0);
    end if;
    for bank in bank_t loop
      word := word or (words(bank) and (word'range => banks(bank)));
    end loop;
    return word;
  end function;

  -- What goes to the blocks.
  subtype address_t is u_unsigned(address_bits(num_words) - 1 downto 0);
  signal bank_writes : std_ulogic_vector(bank_t);
  signal put_address, get_address : address_t;
  signal put_data : std_ulogic_vector(data_bits - 1 downto 0);

begin

  assert 2**address_bits(bank_words) = bank_words
    report "block_ram: bank_words is " & integer'image(bank_words) & ", must be a power of two"
    severity failure;

  bank_gen : for bank in bank_t generate
    constant place_bits : positive := address_bits(bases(bank + 1) - bases(bank));
    -- Every address of so many bits has a word: all banks read, with the enable of all registers.
    constant size : positive := 2 ** place_bits;
    constant most_bits : positive := block_bits(size);
  begin
    block_gen : for index in 0 to (data_bits - 1) / most_bits generate
      constant low : natural := index * most_bits;
      constant high : natural := minimum(low + most_bits, data_bits) - 1;
      type words_t is array (0 to size - 1) of std_ulogic_vector(high - low downto 0);
      signal words : words_t;
    begin
      ports : process (clk)
      begin
        if rising_edge(clk) then
          if bank_writes(bank) = '1' then
            words(to_integer(resize(put_address, place_bits))) <= put_data(high downto low);
          end if;
          if read_enable = '1' then
            fetched(bank)(high downto low) <= words(to_integer(resize(get_address, place_bits)));
          end if;
        end if;
      end process;
    end generate;
  end generate;

  assert read_stages >= 2 and read_stages <= 5
    report "block_ram: read_stages is " & integer'image(read_stages) & ", must be 2 to 5"
    severity failure;

  at_once_gen : if read_stages < 4 generate
    select_gen : for bank in bank_t generate
      bank_writes(bank) <= '1' when write_enable = '1' and is_in(write_address, bank) else '0';
    end generate;
    put_address <= write_address;
    put_data <= write_data;
    get_address <= read_address;
  end generate;

  registers_gen : if read_stages > 3 generate
    ways : process (clk)
    begin
      if rising_edge(clk) then
        bank_writes <= (others => '0');
        for bank in bank_t loop
          if write_enable = '1' and is_in(write_address, bank) then
            bank_writes(bank) <= '1';
          end if;
        end loop;
        put_address <= write_address;
        put_data <= write_data;
        if read_enable = '1' then
          get_address <= read_address;
        end if;
      end if;
    end process;
  end generate;

  beside_gen : if read_stages = 2 generate
    banked <= fetched;
    bank_banked <= bank_read;
  end generate;

  behind_gen : if read_stages > 2 generate
    banks : process (clk)
    begin
      if rising_edge(clk) then
        if read_enable = '1' then
          banked <= fetched;
          bank_banked <= bank_read;
        end if;
      end if;
    end process;
  end generate;

  near_gen : if read_stages < 5 generate
    carried <= banked;
    bank_shown <= bank_banked;
  end generate;

  far_gen : if read_stages = 5 generate
    carry : process (clk)
    begin
      if rising_edge(clk) then
        if read_enable = '1' then
          carried <= banked;
          bank_shown <= bank_banked;
        end if;
      end if;
    end process;
  end generate;

  output : process (clk)
  begin
    if rising_edge(clk) then
      if read_enable = '1' then
        bank_read <= banks_of(get_address);
        read_reg <= chosen(carried, bank_shown);
      end if;
    end if;
  end process;

  read_data <= read_reg;

end architecture;
